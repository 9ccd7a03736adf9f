// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_lane.h"

#include <fmt/format.h>

#include <utility>

#include "daemon/pipeline/log.h"
#include "daemon/ros/wait_until.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

/// Of the 10 messages that roscpp keeps for a slow subscriber; the rest is slack for its own queue.
constexpr std::size_t most_in_flight = 8;
/// After this long a subscriber that takes nothing counts as stuck, and a replay goes on without it.
constexpr auto stuck_subscriber = std::chrono::seconds(10);

std::string ms(Span span) { return fmt::format("{:.1f}", 1e3 * seconds(span)); }

DiagnosticItem topic_item(const std::string& topic, const TopicFigures& f) {
  DiagnosticItem item{"topic " + topic};
  item.message = "publishing";
  if (f.loses)
    item.set(Health::warn, "a subscriber of " + topic +
                               " is too slow and loses messages; `rosnode info` names the subscribers, "
                               "`rostopic bw` the load");
  item.values = {{"Messages/s", fmt::format("{:.1f}", f.rate_hz)},
                 {"Shortest gap of the last 10 s (ms)", ms(f.shortest_gap)},
                 {"Longest gap of the last 10 s (ms)", ms(f.longest_gap)},
                 {"Latency, median (ms)", ms(f.median_latency)},
                 {"Latency, 99 of 100 (ms)", ms(f.p99_latency)},
                 {"Latency, longest (ms)", ms(f.longest_latency)}};
  item.add("Dropped before ROS", f.dropped);
  item.add("Lost by slow subscribers", f.lost);
  return item;
}

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

TopicFigures RosLane::figures(std::size_t topic, Stamp now) const {
  TopicFigures figures = queue_.figures(topic, now);
  figures.lost = publishers_.lost(topic);
  figures.loses = publishers_.loses(topic);
  return figures;
}

void RosLane::add_diagnostics(std::vector<DiagnosticItem>& items, Stamp now) const {
  for (const OutputTopic& topic : topics_) {
    const TopicFigures of_topic = figures(topic.id, now);
    if (of_topic.frames > 0) items.push_back(topic_item(topic.name, of_topic));
  }
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
    log_warn("a subscriber has taken nothing for 10 s; it loses messages from here on");
    return;
  }
}

}  // namespace lidard
