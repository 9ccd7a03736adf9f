// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/Odometry.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_msgs/TFMessage.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "daemon/config/module.h"
#include "daemon/ros/messages/raw_message.h"

namespace lidard {

/// A bag that is written. What fails throws a ros::Exception. Not to be destroyed after that, since rosbag
/// would write on.
class BagFile {
 public:
  virtual ~BagFile() = default;
  virtual void write(const std::string& topic, ros::Time time, const RawMessage& message, bool latched) = 0;
  virtual void close() = 0;
};

/// A message of a bag, as the type that lidard has a use for.
struct BagMessage {
  std::string topic;
  ros::Time time;  ///< when it was recorded
  boost::shared_ptr<sensor_msgs::LaserScan> scan;
  boost::shared_ptr<sensor_msgs::PointCloud2> cloud;
  std::vector<std::uint8_t> bytes;  ///< of another type, serialised
};

/// A topic of a bag.
struct BagTopic {
  std::string name, type;
  std::uint64_t messages = 0;
  double seconds = 0;  ///< from the first message of the bag to the last one
};

/// Bags that are read in the order of time.
class BagReader {
 public:
  virtual ~BagReader() = default;
  virtual const std::vector<BagTopic>& topics() const = 0;
  /// Restricts what next() returns to these topics; begins anew.
  virtual void choose(const std::function<bool(const std::string& topic)>& is_wanted) = 0;
  /// The next message; false at the end. Throws a std::exception that names the files.
  virtual bool next(BagMessage& message) = 0;
};

/// A function of the module that has all of rosbag, which brings Python along: only commands that read or
/// write bags load it.
template <class Function>
Function* bags_function(const char* name) {
  return reinterpret_cast<Function*>(
      module_function("lidard_bags", name, "bags need lidard's module for bags"));
}

}  // namespace lidard

/// Creates or overwrites a bag; the caller owns it.
extern "C" lidard::BagFile* lidard_write_bag(const std::string& path);
/// Reads the transforms of a bag, and the messages of a topic of nav_msgs/Odometry (empty: none). Throws
/// std::exception.
extern "C" void lidard_read_poses(
    const std::string& path, const std::string& odometry_topic,
    const std::function<void(const tf2_msgs::TFMessage& message, bool is_static)>& use_transforms,
    const std::function<void(const nav_msgs::Odometry& message)>& use_odometry);
/// Opens bags that are read as one; the caller owns it. Throws std::exception.
extern "C" lidard::BagReader* lidard_open_bags(const std::vector<std::string>& paths);
