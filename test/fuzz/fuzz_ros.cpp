// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Any bytes as a LaserScan or a PointCloud2 that another node publishes: rejected with a reason, or a frame
// that keeps the invariants; -max_len=8192.
#include <ros/serialization.h>

#include <cmath>
#include <cstdlib>

#include "daemon/ros/messages/convert.h"

namespace {

template <class Message>
bool read(const std::uint8_t* data, std::size_t size, Message& message) {
  // roscpp reads, and does not write.
  ros::serialization::IStream stream(const_cast<std::uint8_t*>(data), static_cast<std::uint32_t>(size));
  try {
    ros::serialization::deserialize(stream, message);
  } catch (const ros::serialization::StreamOverrunException&) {
    return false;
  }
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lidard;
  if (size == 0) return 0;
  sensor_msgs::LaserScan scan_message;
  sensor_msgs::PointCloud2 cloud_message;
  PlanarScan scan;
  Cloud cloud;
  if (data[0] % 2 == 0) {
    if (read(data + 1, size - 1, scan_message) && from_ros(scan_message, scan) == nullptr &&
        violation(scan) != nullptr)
      std::abort();
  } else if (read(data + 1, size - 1, cloud_message) && from_ros(cloud_message, cloud).error == nullptr) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint point = cloud.points()[i];
      if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) std::abort();
    }
  }
  return 0;
}
