// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/ros_samples.h"

#include "daemon/ros/messages/convert.h"
#include "daemon/ros/out/message_rows.h"

namespace lidard::test {

PlanarScan sample_scan() {
  PlanarScan scan;
  scan.frame_id = "front_laser";
  scan.stamp = {1'700'000'000'000'000'005};
  scan.reset(5);
  scan.set_angles(-1.0F, 0.5F);
  scan.time_increment = 1e-4F;
  scan.scan_time = 0.04F;
  scan.range_min = 0.1F;
  scan.range_max = 40.0F;
  scan.set_hit(0, 1.0F);
  scan.set_without_hit(1, BeamStatus::none);
  scan.set_without_hit(2, BeamStatus::near);
  scan.set_hit(4, 40.0F);
  scan.intensities = {10, 20, 30, 40, 50};
  return scan;
}

sensor_msgs::LaserScan sample_message() {
  sensor_msgs::LaserScan message;
  to_message(sample_scan(), message);
  return message;
}

Cloud sample_cloud(std::size_t points) {
  Cloud cloud;
  cloud.frame_id = "/velodyne";
  cloud.stamp = {1'700'000'000'250'000'000};
  cloud.complete = true;
  cloud.rings = 16;
  cloud.points_bytes.resize(points * sizeof(CloudPoint));
  for (std::size_t i = 0; i < points; ++i) {
    const auto n = static_cast<float>(i);
    cloud.points()[i] = {n, -n, n / 2, n + 1, static_cast<std::uint16_t>(i % 16), n * 1e-4F};
  }
  cloud.end = cloud.stamp;
  return cloud;
}

sensor_msgs::PointCloud2 message_of(Cloud cloud, Span step) {
  const RawMessage made = row_of(roof_points).maker()->make(cloud, Stamp(), ClockStep(step));
  sensor_msgs::PointCloud2 message;
  ros::serialization::IStream stream(made.data.message_start, made.size());
  ros::serialization::deserialize(stream, message);
  return message;
}

GnssFix sample_fix() {
  GnssFix fix;
  fix.frame_id = "/velodyne";
  fix.stamp = {1'700'000'000'367'120'000};
  fix.latitude_deg = 36.82913093;
  fix.longitude_deg = -2.40757155;
  fix.altitude_m = 59.5;
  fix.status = FixStatus::sbas;
  fix.source_time = HostStamp{1'700'000'000'000'000'000};
  return fix;
}

TimeReference sample_time_reference() {
  return {{1'700'000'000'709'121'000}, {1'700'000'000'342'001'000}, "gps_pps"};
}

ImuSample sample_imu() {
  ImuSample sample;
  sample.frame_id = "/velodyne";
  sample.stamp = {1'700'000'000'380'293'000};
  sample.angular_velocity = {0.01, -0.02, 0.3};
  sample.linear_acceleration = {0.5, -0.25, 9.8};
  return sample;
}

}  // namespace lidard::test
