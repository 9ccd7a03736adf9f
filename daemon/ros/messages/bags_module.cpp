// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/messages/bags_module.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <memory>
#include <stdexcept>

namespace lidard {
namespace {

/// The connection header of a latched topic; `rosbag play` latches a topic that was recorded with it.
boost::shared_ptr<ros::M_string> latched_header(const MessageType& type) {
  auto header = boost::make_shared<ros::M_string>();
  *header = {{"type", type.name},
             {"md5sum", type.md5},
             {"message_definition", type.definition},
             {"latching", "1"},
             {"callerid", "/lidard"}};
  return header;
}

class WrittenBag final : public BagFile {
 public:
  explicit WrittenBag(const std::string& path) : bag_(path, rosbag::bagmode::Write) {}
  void write(const std::string& topic, ros::Time time, const RawMessage& message, bool latched) override {
    bag_.write(topic, time, message, latched ? latched_header(*message.type) : nullptr);
  }
  void close() override { bag_.close(); }

 private:
  rosbag::Bag bag_;
};

}  // namespace
}  // namespace lidard

extern "C" lidard::BagFile* lidard_write_bag(const std::string& path) { return new lidard::WrittenBag(path); }

extern "C" void lidard_read_poses(const std::string& path, const std::string& odometry_topic,
                                  const std::function<void(const tf2_msgs::TFMessage&, bool)>& use_transforms,
                                  const std::function<void(const nav_msgs::Odometry&)>& use_odometry) {
  const rosbag::Bag bag(path, rosbag::bagmode::Read);
  for (const auto& message : rosbag::View(bag)) {
    const std::string topic = message.getTopic();
    if (const auto tf = message.instantiate<tf2_msgs::TFMessage>())
      use_transforms(*tf, topic == "/tf_static" || topic == "tf_static");
    if (odometry_topic.empty() || (topic != odometry_topic && topic != "/" + odometry_topic)) continue;
    const auto odometry = message.instantiate<nav_msgs::Odometry>();
    if (!odometry) throw std::runtime_error("topic " + topic + " is no nav_msgs/Odometry");
    use_odometry(*odometry);
  }
}

void lidard_read_scans(
    const std::string& path,
    const std::function<void(const std::string& topic, const sensor_msgs::LaserScan& message)>& use_scan,
    const std::function<void(const std::string& topic, const sensor_msgs::PointCloud2& message)>& use_cloud) {
  rosbag::Bag bag(path, rosbag::bagmode::Read);
  for (const auto& message : rosbag::View(bag)) {
    if (const auto scan = message.instantiate<sensor_msgs::LaserScan>())
      use_scan(message.getTopic(), *scan);
    else if (const auto cloud = message.instantiate<sensor_msgs::PointCloud2>())
      use_cloud(message.getTopic(), *cloud);
  }
}
