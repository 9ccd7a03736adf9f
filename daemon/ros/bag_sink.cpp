// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/bag_sink.h"

#include <rosbag/bag.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>

#include "daemon/ros/ros_message.h"

namespace lidard {
namespace {

std::string describe(const std::string& path, const std::exception& problem, int error_number) {
  const std::string why = error_number != 0 ? std::strerror(error_number) : problem.what();
  return "cannot write bag '" + path + "': " + why + "; choose a writable path with enough space";
}

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

struct BagSink::Impl {
  std::string path;
  std::map<std::string, RosMessage> messages_by_topic;
  std::unique_ptr<rosbag::Bag> bag = std::make_unique<rosbag::Bag>();
  std::size_t messages = 0;
  std::string error;
  boost::shared_ptr<ros::M_string> tf_header = latched_header<tf2_msgs::TFMessage>();
  tf2_msgs::TFMessage tf;
  diagnostic_msgs::DiagnosticArray diagnostics;

  /// The bag's destructor writes what is left, and an exception there would end the process: a bag that
  /// cannot be written is put aside for good.
  void give_up(const std::exception& problem, int error_number) {
    static std::vector<std::unique_ptr<rosbag::Bag>>* const broken =
        new std::vector<std::unique_ptr<rosbag::Bag>>;
    if (error.empty()) error = describe(path, problem, error_number);
    broken->push_back(std::move(bag));
  }

  /// Writes a frame; returns the message that it became.
  template <typename Frame>
  RosMessage& write_frame(const OutputTopic& topic, Frame& frame, Stamp released) {
    RosMessage& message = messages_by_topic.try_emplace(topic.name, message_for(topic)).first->second;
    const std::string root = topic.name.compare(0, 1, "/") == 0 ? "" : "/";
    if (convert(frame, message))
      std::visit([&](const auto& held) { write(root + topic.name, released, held); }, message);
    return message;
  }

  template <typename Message>
  void write(const std::string& topic, Stamp released, const Message& message,
             const boost::shared_ptr<ros::M_string>& header = {}) {
    if (!bag) return;
    errno = 0;
    try {
      // A bag refuses the time 0 (ros::TIME_MIN).
      bag->write(topic, std::max(to_ros(released), ros::TIME_MIN), message, header);
      ++messages;
    } catch (const rosbag::BagException& problem) {
      give_up(problem, errno);
    }
  }
};

BagSink::BagSink(const std::string& path) : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  errno = 0;
  try {
    impl_->bag->open(path, rosbag::bagmode::Write);
  } catch (const rosbag::BagException& problem) {
    impl_->give_up(problem, errno);
    throw BagError(impl_->error);
  }
}

BagSink::~BagSink() {
  try {
    close();
  } catch (const BagError&) {
    // A destructor cannot tell; who wants to know calls close().
  }
}

void BagSink::scan(const OutputTopic& topic, const PlanarScan& scan, Stamp released) {
  impl_->write_frame(topic, scan, released);
}

void BagSink::cloud(const OutputTopic& topic, Cloud& cloud, Stamp released) {
  RosMessage& message = impl_->write_frame(topic, cloud, released);
  // The driver gets its own buffer back.
  cloud.points_bytes.swap(std::get<sensor_msgs::PointCloud2>(message).data);
}

void BagSink::message(const OutputTopic& topic, const DeviceMessage& message, Stamp released) {
  impl_->write_frame(topic, message, released);
}

void BagSink::transforms(const std::vector<StaticTransform>& transforms, Stamp released) {
  if (transforms.empty()) return;
  to_ros(transforms, released, impl_->tf);
  impl_->write("/tf_static", released, impl_->tf, impl_->tf_header);
}

void BagSink::diagnostics(const std::vector<DiagnosticItem>& items, Stamp released) {
  if (items.empty()) return;
  to_ros(items, "lidard", released, impl_->diagnostics);
  impl_->write("/diagnostics", released, impl_->diagnostics);
}

std::size_t BagSink::messages() const { return impl_->messages; }
const std::string& BagSink::error() const { return impl_->error; }

void BagSink::close() {
  if (impl_->bag && impl_->bag->isOpen()) {
    errno = 0;
    try {
      impl_->bag->close();
    } catch (const rosbag::BagException& problem) {
      impl_->give_up(problem, errno);
    }
  }
  if (!impl_->error.empty()) throw BagError(impl_->error);
}

}  // namespace lidard
