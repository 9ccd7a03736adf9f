// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "core/base/time.h"

namespace lidard {

/// What `top -H` calls the calling thread; at most 15 characters.
void name_this_thread(const char* name);

/// Tells which of the threads that bring messages to ROS and from it stand still, for a watchdog: ours, and
/// those of roscpp. Each of them makes about ten rounds per second, also when it has nothing to do.
class RosPulse {
  using Clock = std::chrono::steady_clock;

 public:
  /// `sockets`, `server` and `internal` are roscpp's.
  enum Thread : std::size_t { publishing, publishing_clouds, callbacks, sockets, server, internal };

  /// A round of the calling thread; the first one gives the thread its name.
  void tick(Thread thread) { rounds_->tick(thread); }
  /// How long ago the last round of a thread that publishes was.
  Span since_tick() const {
    const Clock::time_point oldest = std::min(rounds_->published[0].load(), rounds_->published[1].load());
    return Clock::now() - oldest;
  }

  /// To be called after each ros::start(), which forgets what was attached before; may wait for the master.
  void attach();
  /// To be called before ros::shutdown().
  void detach() { attached_ = false; }

  /// While it lives, a thread is in a call of roscpp that may wait for the master.
  class Call {
   public:
    explicit Call(RosPulse& pulse) : since_(pulse.called_) { since_ = Clock::now(); }
    ~Call() { since_ = Clock::time_point(); }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

   private:
    std::atomic<Clock::time_point>& since_;
  };

  /// The threads that have not made a round since the last call that returned "". All but those that publish
  /// count while they are attached, those of roscpp only while the master answers: without it any of them may
  /// wait for it. None counts while a Call takes long, since roscpp holds its locks meanwhile. Always to be
  /// called by the same thread.
  std::string standing(bool master_answers);

 private:
  static constexpr std::size_t threads = internal + 1;
  struct Rounds {
    void tick(Thread thread);
    std::array<std::atomic<std::uint64_t>, threads> counts{};
    std::atomic<Clock::time_point> published[2] = {Clock::now(), Clock::now()};  // by lane
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
