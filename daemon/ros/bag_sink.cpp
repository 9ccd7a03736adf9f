// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/bag_sink.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "daemon/ros/ros_outline.h"

namespace lidard {
namespace {

/// The connection header of a latched topic; `rosbag play` latches a topic that was recorded with it.
template <typename Message>
boost::shared_ptr<ros::M_string> latched_header() {
  namespace traits = ros::message_traits;
  auto header = boost::make_shared<ros::M_string>();
  (*header)["type"] = traits::datatype<Message>();
  (*header)["md5sum"] = traits::md5sum<Message>();
  (*header)["message_definition"] = traits::definition<Message>();
  (*header)["latching"] = "1";
  (*header)["callerid"] = "/lidard";
  return header;
}

}  // namespace

/// The bag's destructor writes what is left, and an exception there would end the process: a bag that cannot
/// be written is put aside for good.
void BagSink::give_up(const std::exception& problem, int error_number) {
  static auto* const broken = new std::vector<std::unique_ptr<rosbag::Bag>>;
  const std::string why = error_number != 0 ? std::strerror(error_number) : problem.what();
  if (error_.empty())
    error_ = "cannot write bag '" + path_ + "': " + why + "; choose a writable path with enough space";
  broken->push_back(std::move(bag_));
}

template <class Do>
bool BagSink::attempt(const Do& what) {
  errno = 0;
  try {
    what();
    return true;
  } catch (const rosbag::BagException& problem) {
    give_up(problem, errno);
    return false;
  }
}

template <typename Message>
void BagSink::write(const std::string& topic, Stamp released, const Message& message,
                    const boost::shared_ptr<ros::M_string>& header) {
  // A bag refuses the time 0 (ros::TIME_MIN).
  const ros::Time time = std::max(to_ros(released), ros::TIME_MIN);
  if (bag_ && attempt([&] { bag_->write(topic, time, message, header); })) ++messages_;
}

/// Returns the message that the frame became.
template <typename Frame>
RosMessage& BagSink::write_frame(const OutputTopic& topic, Frame& frame, Stamp released) {
  RosMessage& message = messages_by_topic_.try_emplace(topic.name, message_for(topic)).first->second;
  const std::string root = topic.name.compare(0, 1, "/") == 0 ? "" : "/";
  if (convert(frame, message))
    std::visit([&](const auto& held) { write(root + topic.name, released, held); }, message);
  return message;
}

BagSink::BagSink(const std::string& path) : path_(path), tf_header_(latched_header<tf2_msgs::TFMessage>()) {
  if (!attempt([&] { bag_->open(path, rosbag::bagmode::Write); })) throw BagError(error_);
}

BagSink::~BagSink() {
  try {
    close();
  } catch (const BagError&) {
    // A destructor cannot tell; who wants to know calls close().
  }
}

void BagSink::scan(const OutputTopic& topic, const PlanarScan& scan, Stamp released) {
  write_frame(topic, scan, released);
}

void BagSink::cloud(const OutputTopic& topic, Cloud& cloud, Stamp released) {
  RosMessage& message = write_frame(topic, cloud, released);
  // The driver gets its own buffer back.
  cloud.points_bytes.swap(std::get<sensor_msgs::PointCloud2>(message).data);
}

void BagSink::message(const OutputTopic& topic, const DeviceMessage& message, Stamp released) {
  write_frame(topic, message, released);
}

void BagSink::transforms(const std::vector<StaticTransform>& transforms, Stamp released) {
  if (transforms.empty()) return;
  to_ros(transforms, released, tf_);
  write("/tf_static", released, tf_, tf_header_);
}

void BagSink::diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) {
  if (items.empty()) return;
  to_ros(items, "lidard", released, diagnostics_);
  write("/diagnostics", released, diagnostics_);
}

void BagSink::outline(const VehicleConfig& vehicle, Stamp released) {
  if (vehicle.footprint.empty()) return;
  write(std::string("/") + outline_topic, released, outline_of(vehicle),
        latched_header<geometry_msgs::PolygonStamped>());
}

void BagSink::close() {
  if (bag_ && bag_->isOpen()) attempt([this] { bag_->close(); });
  if (!error_.empty()) throw BagError(error_);
}

}  // namespace lidard
