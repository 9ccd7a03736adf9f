// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_inputs.h"

#include <ros/names.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "daemon/ros/ros_convert.h"
#include "daemon/ros/ros_master.h"
#include "daemon/ros/ros_reception.h"
#include "daemon/ros/velodyne_scan.h"
#include "drivers/net/wall_clock.h"

namespace lidard {
namespace {

/// Messages of one source that may wait for the sensor thread.
constexpr int most_pending = 4;

/// What a usable message held that was not used.
struct LeftOut {
  std::size_t points = 0;
  bool intensities = false;
};

const char* read(const sensor_msgs::LaserScan& message, PlanarScan& scan, LeftOut& left_out) {
  left_out.intensities = !intensities_fit(message);
  return from_ros(message, scan);
}

const char* read(const sensor_msgs::PointCloud2& message, Cloud& cloud, LeftOut& left_out) {
  const auto reading = from_ros(message, cloud);
  left_out.points = reading.dropped;
  return reading.error;
}

}  // namespace

struct RosInputs::Source {
  mutable std::mutex mutex;
  TopicReport report;
  bool packets = false;
  std::optional<FrameKind> kind;
  int pending = 0;
  bool subscribed = false;  // belongs to the master thread

  /// Counts a message; false if the sensor thread is too far behind to take it.
  bool accept() {
    const std::lock_guard lock(mutex);
    ++report.messages;
    if (pending < most_pending) return true;
    ++report.dropped;
    return false;
  }
  /// True if the type is new.
  bool notice_type(const std::string& type) {
    const std::lock_guard lock(mutex);
    if (report.type == type) return false;
    report.type = type;
    report.wrong_type.clear();
    return true;
  }
  void forget_type() {
    const std::lock_guard lock(mutex);
    report.type.clear();
  }
  bool takes(FrameKind frames) const { return !packets && kind.value_or(frames) == frames; }
  std::string expected_type() const {
    if (packets) return ros::message_traits::datatype<VelodyneScanBytes>();
    const char* const scan = takes(FrameKind::scan) ? "sensor_msgs/LaserScan" : "";
    const char* const cloud = takes(FrameKind::cloud) ? "sensor_msgs/PointCloud2" : "";
    return std::string(scan) + (*scan != 0 && *cloud != 0 ? " or " : "") + cloud;
  }
  void refuse_type() {
    const std::lock_guard lock(mutex);
    report.wrong_type = "topic " + report.topic + " carries " + report.type + "; expected " + expected_type();
    spdlog::error("{}", report.wrong_type);
  }
  void reject(const char* reason) {
    const std::lock_guard lock(mutex);
    ++report.rejected;
    if (report.last_reason == reason) return;
    report.last_reason = reason;
    spdlog::warn("messages of {} are not used: {}", report.topic, reason);
  }
  void hand_on(const LeftOut& left_out) {
    const std::lock_guard lock(mutex);
    report.points_dropped += left_out.points;
    report.intensities_ignored += left_out.intensities ? 1 : 0;
    ++pending;
  }
  void taken() {
    const std::lock_guard lock(mutex);
    --pending;
  }
};

namespace {

/// Converts a message and posts it to the sensor thread.
template <typename Frame, typename Message, typename Source, typename Handler>
void receive(const std::shared_ptr<Source>& source, const RosInputs::Post& post, const Handler& handler,
             const Message& message) {
  const Stamp received = wall_clock();
  if (!source->accept()) return;
  auto frame = std::make_shared<Frame>();
  LeftOut left_out;
  if (const char* reason = read(message, *frame, left_out)) {
    source->reject(reason);
    return;
  }
  source->hand_on(left_out);
  post([source, handler, frame, received] {
    handler(source->report.sensor, *frame, received);
    source->taken();
  });
}

}  // namespace

RosInputs::RosInputs(const std::vector<TopicSource>& sources, Post post, TopicHandlers handlers)
    : post_(std::move(post)), handlers_(std::move(handlers)) {
  for (const auto& source : sources) {
    sources_.push_back(std::make_shared<Source>());
    sources_.back()->report.sensor = source.sensor;
    sources_.back()->report.topic = source.topic;
    sources_.back()->packets = source.packets;
    sources_.back()->kind = source.kind;
  }
}

RosInputs::~RosInputs() = default;

void RosInputs::connected() {
  if (!sources_.empty()) reception_ = std::make_unique<RosReception>();
}

void RosInputs::disconnected(bool leave) {
  RosReception::end(reception_, leave);
  for (auto& source : sources_) {
    source->subscribed = false;
    source->forget_type();
  }
}

template <typename Message, typename Frame>
void RosInputs::subscribe_as(const std::shared_ptr<Source>& source,
                             const std::function<void(const std::string&, Frame&, Stamp)>& handler) {
  const boost::function<void(const boost::shared_ptr<const Message>&)> callback =
      [source, post = post_, handler](const auto& message) {
        receive<Frame>(source, post, handler, *message);
      };
  reception_->subscribers.push_back(reception_->node.subscribe<Message>(source->report.topic, 10, callback));
  source->subscribed = true;
}

void RosInputs::subscribe_packets(const std::shared_ptr<Source>& source) {
  using Message = boost::shared_ptr<const VelodyneScanBytes>;
  const boost::function<void(const Message&)> callback =
      [source, post = post_, handler = handlers_.packet](const Message& message) {
        const Stamp received = wall_clock();
        if (!source->accept()) return;
        // Looked at before it is handed on, so that a bad message counts at once.
        const ByteView bytes(message->bytes.data(), message->bytes.size());
        if (const char* reason = read_velodyne_scan(bytes, [](ByteView, Stamp) {})) {
          source->reject(reason);
          return;
        }
        source->hand_on({});
        post([source, handler, message, bytes, received] {
          read_velodyne_scan(bytes, [&](ByteView packet, Stamp arrival) {
            // Nobody stamps 1970; a stamp that was left out is the time at hand.
            handler(source->report.sensor, packet, arrival == Stamp{} ? received : arrival, received);
          });
          source->taken();
        });
      };
  // roscpp itself refuses a publisher of another type or md5sum.
  reception_->subscribers.push_back(
      reception_->node.subscribe<VelodyneScanBytes>(source->report.topic, 10, callback));
  source->subscribed = true;
}

void RosInputs::subscribe(const std::shared_ptr<Source>& source, const std::string& type) {
  if (source->packets && type == ros::message_traits::datatype<VelodyneScanBytes>()) {
    subscribe_packets(source);
  } else if (type == ros::message_traits::datatype<sensor_msgs::LaserScan>() &&
             source->takes(FrameKind::scan)) {
    subscribe_as<sensor_msgs::LaserScan>(source, handlers_.scan);
  } else if (type == ros::message_traits::datatype<sensor_msgs::PointCloud2>() &&
             source->takes(FrameKind::cloud)) {
    subscribe_as<sensor_msgs::PointCloud2>(source, handlers_.cloud);
  } else {
    source->refuse_type();
  }
}

void RosInputs::poll(MasterClient& master) {
  const bool all = std::all_of(sources_.begin(), sources_.end(), [](const auto& s) { return s->subscribed; });
  if (all || !reception_) return;
  const auto types = master.topic_types();
  for (auto& source : sources_) {
    const auto found = types.find(reception_->node.resolveName(source->report.topic));
    // "*" is what a subscriber alone leaves there; a type that was seen before was dealt with.
    if (source->subscribed || found == types.end() || found->second == "*") continue;
    if (source->notice_type(found->second)) subscribe(source, found->second);
  }
}

std::vector<TopicReport> RosInputs::report() const {
  std::vector<TopicReport> all;
  for (const auto& source : sources_) {
    const std::lock_guard lock(source->mutex);
    all.push_back(source->report);
  }
  return all;
}

namespace {

void judge(const TopicReport& report, DiagnosticItem& item) {
  item.health = report.messages == 0 || report.rejected > 0 ? Health::warn : Health::ok;
  item.message = "receiving";
  if (!report.wrong_type.empty()) {
    item.health = Health::error;
    item.message = report.wrong_type;
  } else if (report.messages == 0) {
    item.message = "nobody publishes " + report.topic + "; start its driver";
  } else if (report.rejected > 0) {
    item.message = "unusable messages: " + report.last_reason;
  }
}

}  // namespace

std::vector<DiagnosticItem> RosInputs::diagnostics() {
  std::vector<DiagnosticItem> items;
  for (const auto& r : report()) {
    DiagnosticItem item;
    item.name = r.sensor + " input";
    judge(r, item);
    item.values = {{"Topic", r.topic},
                   {"Type", r.type},
                   {"Messages", std::to_string(r.messages)},
                   {"Rejected", std::to_string(r.rejected)},
                   {"Dropped", std::to_string(r.dropped)},
                   {"Points not finite", std::to_string(r.points_dropped)},
                   {"Intensities ignored", std::to_string(r.intensities_ignored)}};
    items.push_back(std::move(item));
  }
  return items;
}

}  // namespace lidard
