// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/out/message_rows.h"

#include <geometry_msgs/PolygonStamped.h>
#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <stdexcept>

#include "daemon/ros/messages/device_messages.h"
#include "daemon/ros/sick/safety_messages.h"
#include "daemon/ros/velodyne/velodyne_scan.h"

namespace lidard {
namespace {

/// Makes the message of a cloud, which has up to 15 MB, around its points.
template <class AnyCloud>
class CloudMaker final : public MessageMaker {
 public:
  const MessageType& type() const override { return type_of<sensor_msgs::PointCloud2>(); }
  RawMessage make(const Frame& frame, Stamp /*released*/, const ClockStep& clock) override {
    AnyCloud& cloud = *std::get<AnyCloud*>(frame);
    to_ros(cloud, clock.host(cloud.stamp), message_);
    message_.data.clear();
    const RawMessage without_data = raw(message_);
    // What follows the data is `is_dense`.
    const std::size_t head = without_data.data.num_bytes - 1, size = cloud.points_bytes.size();
    if (head > PointBytes::allocator_type::room) {
      message_.data.assign(cloud.points_bytes.begin(), cloud.points_bytes.end());
      return raw(message_);
    }
    const std::shared_ptr<PointBytes> points = free_buffer(size);
    points->swap(cloud.points_bytes);
    points->push_back(message_.is_dense);
    std::uint8_t* const begin = points->data() - head;
    std::memcpy(begin, without_data.data.buf.get(), head);
    constexpr std::size_t length_bytes = sizeof(std::uint32_t);
    write_length(head - length_bytes + size + 1, begin);
    write_length(size, points->data() - length_bytes);
    const boost::shared_array<std::uint8_t> held(begin, [points](std::uint8_t*) {});
    ros::SerializedMessage data(held, head + size + 1);
    data.message_start = begin + length_bytes;
    return {&type(), data};
  }

 private:
  static void write_length(std::size_t length, std::uint8_t* to) {
    ros::serialization::OStream(to, sizeof(std::uint32_t)).next(static_cast<std::uint32_t>(length));
  }
  /// A buffer whose message all sockets have, or a new one. Few free ones are kept: a slow subscriber makes
  /// them many.
  std::shared_ptr<PointBytes> free_buffer(std::size_t size) {
    constexpr std::ptrdiff_t most_free = 3;
    const auto first_free = std::partition(buffers_.begin(), buffers_.end(),
                                           [](const auto& buffer) { return buffer.use_count() > 1; });
    if (buffers_.end() - first_free > most_free) buffers_.erase(first_free + most_free, buffers_.end());
    if (first_free != buffers_.end()) {
      (*first_free)->pop_back();
      return *first_free;
    }
    constexpr std::size_t growth = 100'000;  // from one cloud to the next
    buffers_.push_back(std::make_shared<PointBytes>());
    // Written here, so that the thread that receives packets does not wait for pages of the system.
    buffers_.back()->resize(size + growth);
    return buffers_.back();
  }

  sensor_msgs::PointCloud2 message_;
  std::vector<std::shared_ptr<PointBytes>> buffers_;  // of messages that are on their way, and free ones
};

template <class AnyCloud>
MessageRow cloud_row(TopicKind kind) {
  return {kind, 0, 2,
          []() -> std::unique_ptr<MessageMaker> { return std::make_unique<CloudMaker<AnyCloud>>(); }};
}

std::vector<MessageRow> frame_rows() {
  return {row<PlanarScan, sensor_msgs::LaserScan>(TopicKind::scan, 100),
          row<PlanarScan, sensor_msgs::MultiEchoLaserScan>(TopicKind::echoes, 100),
          cloud_row<Cloud>(TopicKind::cloud), cloud_row<MergedCloud>(TopicKind::merged_cloud)};
}

}  // namespace

const MessageRow& row_of(const OutputTopic& topic) {
  static const std::vector<MessageRow> tables[]{frame_rows(), device_rows(), safety_rows(), velodyne_rows()};
  for (const auto& rows : tables) {
    for (const MessageRow& one : rows)
      if (one.kind == topic.kind && (one.kind != TopicKind::message || one.message == topic.message))
        return one;
  }
  throw std::logic_error("no row for what travels on " + topic.name);
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
