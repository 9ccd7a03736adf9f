// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_inputs.h"

#include <geometry_msgs/TwistStamped.h>
#include <nav_msgs/Odometry.h>
#include <ros/names.h>
#include <sensor_msgs/Imu.h>

#include <algorithm>
#include <atomic>
#include <mutex>
#include <utility>

#include "daemon/pipeline/log.h"
#include "daemon/pipeline/pipeline.h"
#include "daemon/ros/ros_callback_thread.h"
#include "daemon/ros/ros_convert.h"
#include "daemon/ros/ros_master.h"
#include "daemon/ros/velodyne_scan.h"

namespace lidard {
namespace {

/// Messages of one source that may wait for the sensor thread.
constexpr int most_pending = 4;

/// What a usable message held that was not used.
struct LeftOut {
  std::size_t points = 0;
  bool intensities = false;
};

/// What is to be done with a message in the thread of the pipeline.
using Task = std::function<void(Stamp received)>;

/// What the outputs take a source for.
std::optional<FrameKind> use_of(const std::string& sensor, const Config& config) {
  for (const auto& merged : config.merged_scans) {
    const auto& names = merged.laserscan_topics;
    if (std::find(names.begin(), names.end(), sensor) != names.end()) return FrameKind::scan;
  }
  for (const auto& group : config.virtual_scans) {
    if (group.cloud_topic == sensor) return FrameKind::cloud;
  }
  return std::nullopt;
}

/// The master is asked every half second, then a connection is made: until then nobody is missing.
bool may_still_come(std::chrono::steady_clock::time_point connected_at) {
  return std::chrono::steady_clock::now() - connected_at < std::chrono::seconds(2);
}

class RosMotion final : public RosComponent {
 public:
  RosMotion(const VehicleConfig& vehicle, RosPost post, MessageReceiver& receiver)
      : topics_{vehicle.odometry_topic, vehicle.imu_topic, vehicle.speed_topic},
        post_(std::move(post)),
        receiver_(receiver) {}
  void connected(RosCallbackThread& ros) override {
    connected_at_ = std::chrono::steady_clock::now();
    subscribe<nav_msgs::Odometry>(ros, odometry, [&to = receiver_](const nav_msgs::Odometry& m) {
      return [&to, stamp = from_ros(m.header.stamp),
              pose = to_pose(m.pose.pose.position, m.pose.pose.orientation),
              child = m.child_frame_id](Stamp received) { to.pose_message(stamp, pose, child, received); };
    });
    subscribe<sensor_msgs::Imu>(ros, imu, [&to = receiver_](const sensor_msgs::Imu& m) {
      const Eigen::Vector3d rates(m.angular_velocity.x, m.angular_velocity.y, m.angular_velocity.z);
      return [&to, stamp = from_ros(m.header.stamp), rates, frame = m.header.frame_id](Stamp received) {
        to.turn_message(stamp, rates, frame, received);
      };
    });
    subscribe<geometry_msgs::TwistStamped>(ros, speed, [&to = receiver_](const auto& m) {
      return [&to, ahead = m.twist.linear.x](Stamp) { to.speed_message(ahead); };
    });
  }
  std::vector<DiagnosticItem> diagnostics() override {
    std::vector<DiagnosticItem> items;
    for (const Topic i : {odometry, imu, speed}) {
      const std::string& topic = topics_[i];
      const std::uint64_t messages = messages_[i];
      if (topic.empty()) continue;
      DiagnosticItem item{"motion " + topic};
      item.message = "receiving";
      if (messages == 0 && !may_still_come(connected_at_))
        item.set(Health::warn, "nobody publishes " + topic + "; scans are not deskewed");
      item.add("Topic", topic);
      item.add("Messages", messages);
      items.push_back(std::move(item));
    }
    return items;
  }

 private:
  enum Topic : std::size_t { odometry, imu, speed };
  template <typename Message, typename MakeTask>
  void subscribe(RosCallbackThread& ros, Topic topic, MakeTask make_task) {
    constexpr std::uint32_t queue_length = 50;
    if (topics_[topic].empty()) return;
    // A pose that comes late by Nagle's algorithm is a scan that is not deskewed.
    ros.subscribe<Message>(
        topics_[topic], queue_length,
        [this, topic, make_task](const boost::shared_ptr<const Message>& message) {
          ++messages_[topic];
          post_(make_task(*message));
        },
        ros::TransportHints().tcpNoDelay());
  }

  const std::string topics_[3];  // empty: not to be heard
  const RosPost post_;
  MessageReceiver& receiver_;
  std::atomic<std::uint64_t> messages_[3] = {};
  std::chrono::steady_clock::time_point connected_at_{};
};

void judge(const TopicReport& report, bool waits, DiagnosticItem& item) {
  constexpr auto news = std::chrono::seconds(10);
  item.message = "receiving";
  if (!report.wrong_type.empty()) {
    item.set(Health::error, report.wrong_type);
  } else if (report.messages == 0) {
    item.message = "waiting for the first message";
    if (!waits) item.set(Health::warn, "nobody publishes " + report.topic + "; start its driver");
  } else if (report.rejected > 0 && std::chrono::steady_clock::now() - report.rejected_at < news) {
    item.set(Health::warn, "unusable messages: " + report.last_reason);
  }
}

}  // namespace

std::vector<TopicSource> topic_sources(const Config& config) {
  std::vector<TopicSource> sources;
  for (const auto& sensor : config.sensors) {
    if (sensor.model == nullptr && !sensor.handed_over)
      sources.push_back({sensor.name, sensor.topic, false, use_of(sensor.name, config)});
    if (!sensor.packet_topic.empty()) sources.push_back({sensor.name, sensor.packet_topic, true});
  }
  return sources;
}

struct RosInputs::Source {
  mutable std::mutex mutex;
  TopicReport report;
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
  bool takes(FrameKind frames) const { return !report.packets && report.kind.value_or(frames) == frames; }
  void refuse_type() {
    using namespace ros::message_traits;
    std::string expected = report.packets ? datatype<VelodyneScanBytes>() : "";
    if (takes(FrameKind::scan)) expected = datatype<sensor_msgs::LaserScan>();
    if (takes(FrameKind::cloud))
      expected += std::string(expected.empty() ? "" : " or ") + datatype<sensor_msgs::PointCloud2>();
    const std::lock_guard lock(mutex);
    report.wrong_type = "topic " + report.topic + " carries " + report.type + "; expected " + expected;
    log_error("{}", report.wrong_type);
  }
  void reject(const char* reason) {
    const std::lock_guard lock(mutex);
    ++report.rejected;
    report.rejected_at = std::chrono::steady_clock::now();
    if (report.last_reason == reason) return;
    report.last_reason = reason;
    log_warn("messages of {} are not used: {}", report.topic, reason);
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

RosInputs::RosInputs(const std::vector<TopicSource>& sources, RosPost post, MessageReceiver& receiver)
    : post_(std::move(post)), receiver_(receiver) {
  for (const auto& source : sources) {
    sources_.push_back(std::make_shared<Source>());
    static_cast<TopicSource&>(sources_.back()->report) = source;
  }
}

RosInputs::~RosInputs() = default;

void RosInputs::disconnected() {
  ros_ = nullptr;
  for (auto& source : sources_) {
    const std::lock_guard lock(source->mutex);
    source->subscribed = false;
    source->report.type.clear();
  }
}

template <typename Message, typename Read>
void RosInputs::subscribe_as(const std::shared_ptr<Source>& source, Read read) {
  const auto receive = [source, read, post = post_](const boost::shared_ptr<const Message>& message) {
    if (!source->accept()) return;
    Task task;
    LeftOut left_out;
    if (const char* reason = read(message, task, left_out)) return source->reject(reason);
    source->hand_on(left_out);
    post([source, task](Stamp received) {
      task(received);
      source->taken();
    });
  };
  ros_->subscribe<Message>(source->report.topic, 10, receive);
  source->subscribed = true;
}

void RosInputs::subscribe(const std::shared_ptr<Source>& source, const std::string& type) {
  using sensor_msgs::LaserScan;
  using sensor_msgs::PointCloud2;
  const std::string& sensor = source->report.sensor;
  if (source->report.packets && type == ros::message_traits::datatype<VelodyneScanBytes>()) {
    // roscpp itself refuses a publisher of another type or md5sum.
    subscribe_as<VelodyneScanBytes>(
        source, [&receiver = receiver_, sensor](const auto& message, Task& task, LeftOut&) {
          const ByteView bytes(message->bytes.data(), message->bytes.size());
          task = [=, &receiver, keeps_bytes = message](Stamp received) {
            read_velodyne_scan(bytes, [&](ByteView packet, Stamp arrival) {
              // Nobody stamps 1970; a stamp that was left out is the time at hand.
              receiver.packet_message(sensor, {packet, arrival == Stamp{} ? received : arrival, {}, {}},
                                      received);
            });
          };
          // Looked at before it is handed on, so that a bad message counts at once.
          return read_velodyne_scan(bytes, [](ByteView, Stamp) {});
        });
  } else if (type == ros::message_traits::datatype<LaserScan>() && source->takes(FrameKind::scan)) {
    subscribe_as<LaserScan>(
        source, [&receiver = receiver_, sensor](const auto& message, Task& task, LeftOut& left_out) {
          const auto scan = std::make_shared<PlanarScan>();
          task = [=, &receiver](Stamp received) { receiver.scan_message(sensor, *scan, received); };
          left_out.intensities = !intensities_fit(*message);
          return from_ros(*message, *scan);
        });
  } else if (type == ros::message_traits::datatype<PointCloud2>() && source->takes(FrameKind::cloud)) {
    subscribe_as<PointCloud2>(
        source, [&receiver = receiver_, sensor](const auto& message, Task& task, LeftOut& left_out) {
          const auto cloud = std::make_shared<Cloud>();
          task = [=, &receiver](Stamp received) { receiver.cloud_message(sensor, *cloud, received); };
          const CloudReading reading = from_ros(*message, *cloud);
          left_out.points = reading.dropped;
          return reading.error;
        });
  } else {
    source->refuse_type();
  }
}

void RosInputs::poll(MasterClient& master) {
  const bool all = std::all_of(sources_.begin(), sources_.end(), [](const auto& s) { return s->subscribed; });
  if (all || ros_ == nullptr) return;
  const auto types = master.topic_types();
  for (auto& source : sources_) {
    const auto found = types.find(ros::names::resolve(source->report.topic));
    // "*" is what a subscriber alone leaves there; a type that was seen before was dealt with.
    if (source->subscribed || found == types.end() || found->second == "*") continue;
    {
      const std::lock_guard lock(source->mutex);
      if (std::exchange(source->report.type, found->second) == found->second) continue;
      source->report.wrong_type.clear();
    }
    subscribe(source, found->second);
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

std::vector<DiagnosticItem> RosInputs::diagnostics() {
  std::vector<DiagnosticItem> items;
  for (const auto& r : report()) {
    DiagnosticItem item{r.sensor + " input"};
    judge(r, may_still_come(connected_at_), item);
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

std::shared_ptr<RosComponent> make_ros_motion(const VehicleConfig& vehicle, RosPost post,
                                              MessageReceiver& receiver) {
  return std::make_shared<RosMotion>(vehicle, std::move(post), receiver);
}

}  // namespace lidard
