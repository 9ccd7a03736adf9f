// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_lane.h"

#include <spdlog/spdlog.h>

#include <utility>

#include "daemon/ros/wait_until.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

/// Of the 10 messages that roscpp keeps for a slow subscriber; the rest is slack for its own queue.
constexpr std::size_t most_in_flight = 8;
/// After this long a subscriber that takes nothing counts as stuck, and a replay goes on without it.
constexpr auto stuck_subscriber = std::chrono::seconds(10);

}  // namespace

RosLane::RosLane(const RosOptions& options, const std::vector<OutputTopic>& topics, RosPulse& pulse,
                 RosPulse::Thread thread, TakeDiagnostics diagnostics)
    : block_(options.backpressure == Backpressure::block),
      topics_(topics),
      queue_(topics, options.backpressure),
      publishers_(topics, options.clock),
      pulse_(pulse),
      number_(thread),
      diagnostics_(std::move(diagnostics)) {}

void RosLane::continue_after(RosLane& before) {
  publishers_.adopt(before.publishers_);
  for (const OutputTopic& topic : topics_) {
    for (const OutputTopic& known : before.topics_) {
      if (known.name == topic.name) queue_.continue_figures(topic.id, before.queue_, known.id);
    }
  }
  published_ = before.published_.load();
  without_ros_ = before.without_ros_.load();
}

void RosLane::start() {
  thread_ = std::thread([this] { run(); });
}

void RosLane::stop() {
  stopping_ = true;
  queue_.stop();
  if (thread_.joinable()) thread_.join();
}

void RosLane::finish() {
  finishing_ = true;
  if (thread_.joinable()) thread_.join();
}

void RosLane::run() {
  constexpr auto between_counts = std::chrono::milliseconds(100);
  auto counted = std::chrono::steady_clock::now();
  while (!stopping_) {
    pulse_.tick(number_);
    QueuedFrame* frame = queue_.pop(between_counts);
    if (const auto now = std::chrono::steady_clock::now(); now - counted >= between_counts) {
      publishers_.count_subscribers();
      counted = now;
    }
    if (frame == nullptr) {
      if (finishing_) return;
      continue;
    }
    if (deal_with(*frame))
      queue_.published(frame, wall_clock());
    else
      queue_.done(frame);
  }
}

/// True if it was published: there is ROS.
bool RosLane::deal_with(QueuedFrame& frame) {
  if (block_) wait_for_subscribers_of(frame);
  const bool sent = publishers_.publish(frame);
  ++(sent ? published_ : without_ros_);
  return sent;
}

void RosLane::wait_for_subscribers_of(const QueuedFrame& frame) {
  const auto keeps_up = [&] {
    pulse_.tick(number_);
    const bool advertised = publishers_.ready() || frame.lane == queue_.transforms_lane();
    return stopping_ || (advertised && publishers_.in_flight(frame) < most_in_flight);
  };
  while (!wait_until(keeps_up, stuck_subscriber)) {
    if (!publishers_.ready()) continue;
    spdlog::warn("a subscriber has taken nothing for 10 s; it loses messages from here on");
    return;
  }
}

}  // namespace lidard
