// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>

#include "core/base/time.h"

namespace lidard {

/// Reports the stalled threads between the daemon and ROS, for a watchdog. Each of them makes about ten
/// rounds per second, also when it has nothing to do.
class ThreadWatch {
  using Clock = std::chrono::steady_clock;

 public:
  ThreadWatch() {
    for (auto& at : last_) at = Clock::now();
  }

  enum Thread : std::size_t { publishing, callbacks, master };

  /// A round of the calling thread; the first one gives the thread its name.
  void tick(Thread thread);
  /// Time since the last round of a thread.
  Span since_tick(Thread thread) const { return Clock::now() - last_[thread].load(); }

  /// The thread for callbacks exists while ROS runs.
  void set_running(bool runs) { runs_ = runs; }

  /// While it lives, the master thread is in a call that may wait for the master. Calls may nest.
  class Call {
   public:
    explicit Call(ThreadWatch& pulse) : since_(pulse.called_), outer_(since_) {
      if (outer_ == Clock::time_point()) since_ = Clock::now();
    }
    ~Call() { since_ = outer_; }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

   private:
    std::atomic<Clock::time_point>& since_;
    const Clock::time_point outer_;
  };

  /// The threads that have not made a round since the last call that returned "". The master thread counts
  /// only while the master answers: otherwise it may wait for it. None counts during a long Call, since
  /// roscpp holds its locks then. Always to be called by the same thread.
  std::string stalled(bool master_answers);

 private:
  static constexpr std::size_t threads = master + 1;

  std::array<std::atomic<std::uint64_t>, threads> rounds_{};
  std::array<std::atomic<Clock::time_point>, threads> last_;
  std::atomic<Clock::time_point> called_{Clock::time_point()};
  std::atomic<bool> runs_{false};
  std::array<std::uint64_t, threads> before_{};
};

}  // namespace lidard
