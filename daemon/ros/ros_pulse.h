// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "core/base/time.h"

namespace lidard {

/// What `top -H` calls the calling thread; at most 15 characters.
void name_this_thread(const char* name);

/// Tells which of the threads that bring messages to ROS stand still, for a watchdog: our ROS thread, and
/// those of roscpp. Each of them makes about ten rounds per second, also when it has nothing to do.
class RosPulse {
  using Clock = std::chrono::steady_clock;

 public:
  /// A round of the ROS thread.
  void tick();
  std::uint64_t ticks() const { return ticks_; }
  /// How long ago the last round of the ROS thread was.
  Span since_tick() const { return Clock::now() - ticked_.load(); }

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

  /// The threads that have not made a round since the last call that returned "". Those of roscpp count while
  /// they are attached and the master answers: without it any of them may wait for it. None counts while a
  /// Call takes long, since roscpp holds its locks meanwhile. Always to be called by the same thread.
  std::string standing(bool master_answers);

 private:
  struct Counts {
    std::atomic<std::uint64_t> sockets{0};
    std::atomic<std::uint64_t> server{0};
    std::atomic<std::uint64_t> callbacks{0};
    std::atomic<bool> callback_waits{false};
  };
  class ServerRound;
  class CallbackRound;
  struct Rounds {
    std::uint64_t ros = 0, sockets = 0, server = 0, callbacks = 0;
  };

  std::shared_ptr<Counts> counts_ = std::make_shared<Counts>();
  std::atomic<std::uint64_t> ticks_{0};
  std::atomic<Clock::time_point> ticked_{Clock::now()};
  std::atomic<Clock::time_point> called_{Clock::time_point()};
  std::atomic<bool> attached_{false};
  Rounds before_;
};

}  // namespace lidard
