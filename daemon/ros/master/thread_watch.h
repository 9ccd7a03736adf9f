// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "core/base/time.h"

namespace lidard {

/// Reports the stalled threads between the daemon and ROS, for a watchdog: own threads and those of roscpp.
/// Each of them makes about ten rounds per second, also when it has nothing to do.
class ThreadWatch {
  using Clock = std::chrono::steady_clock;

 public:
  /// `sockets`, `server` and `internal` are roscpp's.
  enum Thread : std::size_t { publishing, callbacks, sockets, server, internal, master };

  /// A round of the calling thread; the first one gives the thread its name.
  void tick(Thread thread) { rounds_->tick(thread); }
  /// Time since the last round of an own thread.
  Span since_tick(Thread thread) const { return Clock::now() - rounds_->last[thread].load(); }

  /// To be called after each ros::start(), which forgets what was attached before; may wait for the master.
  void attach();
  /// To be called before ros::shutdown().
  void detach() { attached_ = false; }

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

  /// The threads that have not made a round since the last call that returned "". Threads of roscpp count
  /// while they are attached. They and the master thread count only while the master answers: otherwise any
  /// of them may wait for it. None counts during a long Call, since roscpp holds its locks then. Always to be
  /// called by the same thread.
  std::string standing(bool master_answers);

 private:
  static constexpr std::size_t threads = master + 1;
  struct Rounds {
    Rounds() {
      for (auto& at : last) at = Clock::now();
    }
    void tick(Thread thread);
    std::array<std::atomic<std::uint64_t>, threads> counts{};
    std::array<std::atomic<Clock::time_point>, threads> last;
    std::atomic<bool> callback_waits{false};
  };
  class ServerRound;
  class InternalRound;

  std::shared_ptr<Rounds> rounds_ = std::make_shared<Rounds>();
  std::atomic<Clock::time_point> called_{Clock::time_point()};
  std::atomic<bool> attached_{false};
  std::array<std::uint64_t, threads> before_{};
};

}  // namespace lidard
