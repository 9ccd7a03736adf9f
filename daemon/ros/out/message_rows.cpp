// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/out/message_rows.h"

#include <geometry_msgs/PolygonStamped.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "daemon/ros/messages/convert.h"
#include "daemon/ros/messages/device_messages.h"
#include "daemon/ros/sick/safety_messages.h"
#include "daemon/ros/velodyne/velodyne_scan.h"

namespace lidard {
namespace {

template <class Frame>
constexpr bool is_device_message = std::is_constructible_v<DeviceMessage, Frame>;

template <class Frame>
auto& frame_in(const Payload& payload) {
  if constexpr (is_device_message<Frame>)
    return std::get<Frame>(*std::get<const DeviceMessage*>(payload));
  else if constexpr (std::is_same_v<Frame, Cloud>)
    return *std::get<Cloud*>(payload);
  else
    return *std::get<const Frame*>(payload);
}

template <class Frame, class Message>
class MakerOf final : public MessageMaker {
 public:
  const MessageType& type() const override { return type_of<Message>(); }
  RawMessage make(const Payload& payload, Stamp released) override {
    auto& frame = frame_in<Frame>(payload);
    if constexpr (std::is_same_v<Frame, std::vector<StaticTransform>>)
      to_ros(frame, released, message_);
    else if constexpr (std::is_same_v<Frame, Stamp>)
      message_.clock = to_ros(frame);
    else
      to_ros(frame, message_);
    RawMessage made = raw(message_);
    if constexpr (std::is_same_v<Frame, Cloud>) message_.data.swap(frame.points_bytes);
    return made;
  }

 private:
  Message message_;
};

template <class Frame, class Message>
std::unique_ptr<MessageMaker> make_maker() {
  return std::make_unique<MakerOf<Frame, Message>>();
}

template <class Frame, class Message>
constexpr MessageRow row(TopicKind kind, std::size_t queue_depth) {
  std::size_t message = 0;
  if constexpr (is_device_message<Frame>) message = message_kind<Frame>();
  return {kind, message, queue_depth, make_maker<Frame, Message>};
}

constexpr MessageRow rows[]{row<PlanarScan, sensor_msgs::LaserScan>(TopicKind::scan, 100),
                            row<PlanarScan, sensor_msgs::MultiEchoLaserScan>(TopicKind::echoes, 100),
                            row<PlanarScan, ExtendedScanMessage>(TopicKind::extended_scan, 100),
                            row<Cloud, sensor_msgs::PointCloud2>(TopicKind::cloud, 2),
                            row<DeviceState, OutputPathsMessage>(TopicKind::output_paths, 100),
                            row<GnssFix, sensor_msgs::NavSatFix>(TopicKind::message, 2),
                            row<TimeReference, sensor_msgs::TimeReference>(TopicKind::message, 2),
                            row<ImuSample, sensor_msgs::Imu>(TopicKind::message, 50),
                            row<DeviceState, diagnostic_msgs::DiagnosticArray>(TopicKind::message, 2),
                            row<RawPackets, VelodyneScanMessage>(TopicKind::message, 2)};

}  // namespace

const MessageRow& row_of(const OutputTopic& topic) {
  const auto* const found = std::find_if(std::begin(rows), std::end(rows), [&](const MessageRow& one) {
    return one.kind == topic.kind && (one.kind != TopicKind::message || one.message == topic.message);
  });
  if (found == std::end(rows)) throw std::logic_error("no row for what travels on " + topic.name);
  return *found;
}

std::unique_ptr<MessageMaker> transforms_maker() {
  return make_maker<std::vector<StaticTransform>, tf2_msgs::TFMessage>();
}
std::unique_ptr<MessageMaker> clock_maker() { return make_maker<Stamp, rosgraph_msgs::Clock>(); }

RawMessage outline_of(const VehicleConfig& vehicle) {
  geometry_msgs::PolygonStamped message;
  message.header.frame_id = ros_frame(vehicle.base_frame);
  for (const Eigen::Vector2d& vertex : vehicle.footprint) {
    geometry_msgs::Point32 point;
    point.x = static_cast<float>(vertex.x());
    point.y = static_cast<float>(vertex.y());
    message.polygon.points.push_back(point);
  }
  return raw(message);
}

}  // namespace lidard
