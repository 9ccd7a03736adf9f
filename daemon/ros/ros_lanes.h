// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "daemon/config/lanes.h"
#include "daemon/ros/ros_lane.h"

namespace lidard {

/// The lanes of a connection to ROS, by number of Lane. Another configuration has others: they are made
/// beside those in use, which are given up when the pipelines have changed over. Any thread may call.
class RosLanes {
 public:
  using Topics = std::array<std::vector<OutputTopic>, 2>;
  using Pair = std::array<std::shared_ptr<RosLane>, 2>;
  using TakeDiagnostics = std::function<void(std::size_t lane, const std::vector<DiagnosticItem>&)>;

  /// `options` and `pulse` must outlive this.
  RosLanes(const RosOptions& options, const Topics& topics, RosPulse& pulse, TakeDiagnostics take)
      : options_(options), pulse_(pulse), take_(std::move(take)), current_(make(topics)) {}

  Pair current() const {
    const std::lock_guard lock(mutex_);
    return current_;
  }
  RosLane& of(Lane lane) const { return *current()[static_cast<std::size_t>(lane)]; }
  /// With those of a change that is not finished.
  std::vector<std::shared_ptr<RosLane>> all() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::shared_ptr<RosLane>> all(current_.begin(), current_.end());
    if (next_[0] != nullptr) all.insert(all.end(), next_.begin(), next_.end());
    return all;
  }
  /// The sum of what `figure` says of each lane.
  template <class Figure>
  std::uint64_t sum(Figure figure) const {
    std::uint64_t all = 0;
    for (const auto& lane : current()) all += figure(*lane);
    return all;
  }
  std::uint64_t dropped() const {
    return sum([](const RosLane& lane) { return lane.queue().dropped(); });
  }
  std::uint64_t published() const {
    return sum([](const RosLane& lane) { return lane.published(); });
  }
  std::uint64_t without_ros() const {
    return sum([](const RosLane& lane) { return lane.without_ros(); });
  }
  std::uint64_t subscribers() const {
    return sum([](const RosLane& lane) { return lane.publishers().subscribers(); });
  }
  bool is_ready() const {
    const auto ready = sum([](const RosLane& lane) { return lane.publishers().ready() ? 1 : 0; });
    return ready == current_.size();
  }
  /// By how much the host's clock was set.
  Span step() const {
    const std::lock_guard lock(mutex_);
    return step_;
  }
  void set_step(Span step) {
    const std::lock_guard lock(mutex_);
    step_ = step;
    for (const Pair* pair : {&current_, &next_}) {
      for (const auto& lane : *pair) {
        if (lane != nullptr) lane->queue().set_step(step);
      }
    }
  }

  /// Makes and starts the lanes of a change.
  Pair begin_change(const Topics& topics) {
    const Pair former = current();
    Pair fresh = make(topics);
    for (std::size_t i = 0; i < fresh.size(); ++i) {
      fresh[i]->continue_after(*former[i]);
      fresh[i]->start();
    }
    const std::lock_guard lock(mutex_);
    return next_ = fresh;
  }
  /// Nobody uses the lanes before the change any more.
  void finish_change() {
    const std::lock_guard lock(mutex_);
    retired_.assign(current_.begin(), current_.end());
    current_ = std::exchange(next_, {});
  }
  bool has_retired() const {
    const std::lock_guard lock(mutex_);
    return !retired_.empty();
  }
  /// Publishes what the former lanes still hold. May wait for the master, unless `leave`.
  void end_retired(bool leave) {
    std::unique_lock lock(mutex_);
    const auto former = std::exchange(retired_, {});
    lock.unlock();
    for (const auto& lane : former) {
      lane->finish();
      lane->publishers().drop(leave);
    }
  }

 private:
  Pair make(const Topics& topics) {
    constexpr std::array<RosPulse::Thread, 2> threads{RosPulse::publishing, RosPulse::publishing_clouds};
    Pair made;
    for (std::size_t i = 0; i < topics.size(); ++i) {
      const auto take = [this, i](const std::vector<DiagnosticItem>& items) { take_(i, items); };
      made[i] = std::make_shared<RosLane>(options_, topics[i], pulse_, threads[i], take);
      made[i]->queue().set_step(step_);
    }
    return made;
  }

  const RosOptions& options_;
  RosPulse& pulse_;
  const TakeDiagnostics take_;
  mutable std::mutex mutex_;
  Span step_{0};
  Pair current_, next_;  // next_: of a change that is not finished
  std::vector<std::shared_ptr<RosLane>> retired_;
};

}  // namespace lidard
