// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/messages/bags_module.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <map>
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

std::unique_ptr<rosbag::Bag> opened(const std::string& path) {
  try {
    return std::make_unique<rosbag::Bag>(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagException& problem) {
    throw std::runtime_error(std::string(problem.what()) +
                             "; run `rosbag reindex` on a bag that was not closed or was cut off");
  }
}

class OpenBags final : public BagReader {
 public:
  explicit OpenBags(const std::vector<std::string>& paths) {
    std::map<std::string, BagTopic> all;
    for (const std::string& path : paths) {
      try {
        bags_.push_back(opened(path));
      } catch (const std::runtime_error& problem) {
        throw std::runtime_error(path + ": " + problem.what());
      }
      rosbag::View view(*bags_.back());
      for (const rosbag::ConnectionInfo* connection : view.getConnections())
        all[connection->topic] = {connection->topic, connection->datatype, 0, 0};
      for (auto& [name, topic] : all) {
        rosbag::View one(*bags_.back(), rosbag::TopicQuery(name));
        topic.messages += one.size();
        if (one.size() > 0) topic.seconds += (view.getEndTime() - view.getBeginTime()).toSec();
      }
    }
    for (const auto& [name, topic] : all) topics_.push_back(topic);
  }
  const std::vector<BagTopic>& topics() const override { return topics_; }
  void choose(const std::function<bool(const std::string&)>& is_wanted) override {
    std::vector<std::string> names;
    for (const BagTopic& topic : topics_)
      if (is_wanted(topic.name)) names.push_back(topic.name);
    view_ = std::make_unique<rosbag::View>();
    for (const auto& bag : bags_) view_->addQuery(*bag, rosbag::TopicQuery(names));
    at_ = view_->begin();
  }
  bool next(BagMessage& message) override {
    if (at_ == view_->end()) return false;
    try {
      read(*at_, message);
      ++at_;
    } catch (const std::exception& problem) {
      std::string files;
      for (const auto& bag : bags_) files += bag->getFileName() + ": ";
      throw std::runtime_error(files + problem.what());
    }
    return true;
  }

 private:
  static void read(const rosbag::MessageInstance& from, BagMessage& message) {
    message.topic = from.getTopic();
    message.time = from.getTime();
    message.scan = from.instantiate<sensor_msgs::LaserScan>();
    message.cloud = from.instantiate<sensor_msgs::PointCloud2>();
    message.bytes.clear();
    if (message.scan || message.cloud) return;
    message.bytes.resize(from.size());
    ros::serialization::OStream stream(message.bytes.data(), from.size());
    from.write(stream);
  }

  std::vector<std::unique_ptr<rosbag::Bag>> bags_;
  std::vector<BagTopic> topics_;
  std::unique_ptr<rosbag::View> view_;
  rosbag::View::iterator at_;
};

}  // namespace
}  // namespace lidard

extern "C" lidard::BagFile* lidard_write_bag(const std::string& path) { return new lidard::WrittenBag(path); }

extern "C" void lidard_read_poses(const std::string& path, const std::string& odometry_topic,
                                  const std::function<void(const tf2_msgs::TFMessage&, bool)>& use_transforms,
                                  const std::function<void(const nav_msgs::Odometry&)>& use_odometry) {
  const auto bag = lidard::opened(path);
  for (const auto& message : rosbag::View(*bag)) {
    const std::string topic = message.getTopic();
    if (const auto tf = message.instantiate<tf2_msgs::TFMessage>())
      use_transforms(*tf, topic == "/tf_static" || topic == "tf_static");
    if (odometry_topic.empty() || (topic != odometry_topic && topic != "/" + odometry_topic)) continue;
    const auto odometry = message.instantiate<nav_msgs::Odometry>();
    if (!odometry) throw std::runtime_error("topic " + topic + " is no nav_msgs/Odometry");
    use_odometry(*odometry);
  }
}

extern "C" lidard::BagReader* lidard_open_bags(const std::vector<std::string>& paths) {
  return new lidard::OpenBags(paths);
}
