// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A LaserScan or a PointCloud2 of another node with any values: rejected with a reason, or a frame that keeps
// the invariants. The message is made of the input in place of roscpp's own reading, which allocates whatever
// number of elements a message claims to have; -max_len=8192.
#include <cmath>
#include <cstdlib>

#include "daemon/ros/messages/convert.h"
#include "test/support/random_bytes.h"

namespace {

using namespace lidard;
using sim::Bytes;

std::uint32_t any_number(Bytes& in) {
  const auto low = static_cast<std::uint32_t>(in.below(65536));
  return in.chance(200) ? low % 64 : low << 16U | static_cast<std::uint32_t>(in.below(65536));
}

void scan(Bytes& in) {
  sensor_msgs::LaserScan message;
  message.header.stamp = {any_number(in), any_number(in) % 1'000'000'000};
  for (float* value : {&message.angle_min, &message.angle_max, &message.angle_increment,
                       &message.time_increment, &message.scan_time, &message.range_min, &message.range_max})
    *value = in.chance(128) ? in.any_float() : static_cast<float>(in.between(-4, 60));
  message.ranges.resize(in.below(200));
  message.intensities.resize(in.chance(200) ? message.ranges.size() : in.below(200));
  for (float& range : message.ranges) range = in.any_float();
  for (float& intensity : message.intensities) intensity = in.any_float();
  PlanarScan scan;
  // A message without ranges gives a scan without beams.
  if (from_ros(message, scan) == nullptr && scan.beams > 0 && violation(scan) != nullptr) std::abort();
}

void cloud(Bytes& in) {
  static const char* const names[] = {"x", "y", "z", "intensity", "ring", "time", "t", "rgb", ""};
  sensor_msgs::PointCloud2 message;
  message.header.stamp = {any_number(in), any_number(in) % 1'000'000'000};
  message.height = any_number(in);
  message.width = any_number(in);
  message.point_step = any_number(in);
  message.row_step = in.chance(128) ? message.width * message.point_step : any_number(in);
  message.is_bigendian = in.chance(64);
  message.is_dense = in.chance(128);
  message.fields.resize(in.below(10));
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    auto& field = message.fields[i];
    field.name = in.chance(200) ? names[i % 9] : names[in.below(9)];
    field.offset = in.chance(128) ? static_cast<std::uint32_t>(4 * i) : any_number(in);
    field.datatype = static_cast<std::uint8_t>(in.chance(128) ? 7 : in.byte());
    field.count = in.chance(200) ? 1 : any_number(in);
  }
  message.data.resize(in.chance(128) ? std::size_t{message.row_step} * message.height % 65536
                                     : in.below(4096));
  for (auto& byte : message.data) byte = in.byte();
  Cloud cloud;
  if (from_ros(message, cloud).error != nullptr) return;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint point = cloud.points()[i];
    if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in(data, size);
  in.chance(128) ? scan(in) : cloud(in);
  return 0;
}
