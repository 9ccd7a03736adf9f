// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using ::testing::HasSubstr;

const std::string everything =
    "vehicle: {base_frame: base, footprint: [[-4, -1], [0.1, -1], [0.1, 1]], odometry_frame: odom}\n"
    "sensors:\n"
    "  roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, pose: {xyz: [0.1, -0.2, 2], rpy_deg: [1, -2, "
    "30]}, "
    "multicast_group: 239.1.2.3, interface: 'true', clock: arrival, time_offset: -0.123456789, cut_angle: "
    "0.3}\n"
    "  open: {model: velodyne_vlp16, frame_id: 'null'}\n"
    "  rear: {topic: /rear/scan, frame_id: 'rear:#1'}\n"
    "merged_scans:\n"
    "  m: {laserscan_topics: rear, destination_frame: other, angle_min: -2.36, angle_max: 2.36, "
    "angle_increment: 0.0058, time_increment: 1e-5, empty: nan, min_height: -0.3, lost_after: 0.0333333}\n"
    "  n: {laserscan_topics: rear, cloud_destination_topic: c, angle_max: 1, empty: range_max_plus_one, "
    "profile: strict, also: {s: safety}}\n"
    "merged_clouds:\n"
    "  all: {sources: [roof, open], destination_frame: mid, destination_pose: {xyz: [1, 0, 0]}, "
    "destination_topic: "
    "/both, organize_cloud: true, policy: trigger, trigger: open, deadline: 0.02, lost_after: 1, "
    "on_missing_motion: "
    "wait}\n"
    "virtual_scans:\n"
    "  t: {cloud_topic: all, virtual_laser_scan: [h], profile: strict}\n"
    "  v: {cloud_topic: roof, virtual_laser_scan: [a, b, base], poses: {a: {xyz: [1, 2, 3], rpy: [0, 0.1, "
    "0]}}, "
    "beams: 77, range_max: 30}\n"
    "  w: {cloud_topic: open, base_frame: x, virtual_laser_scan: [d, e], output_laser_topic: /all}\n"
    "  s: {cloud_topic: roof, virtual_laser_scan: [f, g], profile: strict, mode: band, min_height: 0.1, "
    "max_height: 1.9, ground: {model: slope, z: 0.2, tolerance: 0.07}, echoes: all, "
    "no_return_free_range: 40, also: {safe: safety, flat: flatten}}\n";

/// What to_yaml() leaves unsaid or rounds is compared here, everything else by its text.
void expect_same(const Config& a, const Config& b) {
  ASSERT_EQ(a.sensors.size(), b.sensors.size());
  for (std::size_t i = 0; i < a.sensors.size(); ++i) {
    EXPECT_EQ(a.sensors[i].model, b.sensors[i].model);
    EXPECT_EQ(a.sensors[i].driver.time_offset, b.sensors[i].driver.time_offset);
    ASSERT_EQ(a.sensors[i].pose.has_value(), b.sensors[i].pose.has_value());
    if (a.sensors[i].pose) {
      EXPECT_TRUE(a.sensors[i].pose->isApprox(*b.sensors[i].pose, 1e-9));
    }
  }
  ASSERT_EQ(a.merged_scans.size(), b.merged_scans.size());
  for (std::size_t i = 0; i < a.merged_scans.size(); ++i) {
    EXPECT_EQ(a.merged_scans[i].output.grid.angle_min, b.merged_scans[i].output.grid.angle_min);
    EXPECT_EQ(a.merged_scans[i].output.grid.angle_increment, b.merged_scans[i].output.grid.angle_increment);
    EXPECT_EQ(a.merged_scans[i].output.max_height, b.merged_scans[i].output.max_height);
    EXPECT_EQ(a.merged_scans[i].destination_pose.has_value(), b.merged_scans[i].destination_pose.has_value());
    EXPECT_EQ(a.merged_scans[i].schedule.lost_after, b.merged_scans[i].schedule.lost_after);
  }
  ASSERT_EQ(a.merged_clouds.size(), b.merged_clouds.size());
  EXPECT_TRUE(a.merged_clouds == b.merged_clouds);
  ASSERT_EQ(a.virtual_scans.size(), b.virtual_scans.size());
  for (std::size_t i = 0; i < a.virtual_scans.size(); ++i)
    EXPECT_EQ(a.virtual_scans[i].poses.size(), b.virtual_scans[i].poses.size());
  EXPECT_EQ(a.virtual_scans.back().ground.tolerance, b.virtual_scans.back().ground.tolerance);
  EXPECT_EQ(a.virtual_scans.back().also.size(), b.virtual_scans.back().also.size());
  EXPECT_EQ(a.warnings.size(), b.warnings.size());
}

TEST(ToYaml, ReadsBackToTheSame) {
  const Config config = parse_config(everything, "f");
  const std::string yaml = to_yaml(config);
  const Config again = parse_config(yaml, "g");
  EXPECT_EQ(to_yaml(again), yaml);
  expect_same(config, again);
  EXPECT_EQ(again.sensors[0].interface, "true");
  EXPECT_EQ(again.sensors[1].frame_id, "null");
  EXPECT_EQ(again.sensors[2].frame_id, "rear:#1");
}

TEST(ToYaml, FillsInEveryDefault) {
  const std::string yaml = to_yaml(parse_config(everything, "f"));
  for (const char* line :
       {"    ip_port: 2368\n", "    # ip_address: any sender that no other sensor claims\n",
        "    # pose: from tf\n", "    clock: smooth\n", "    profile: flatten\n", "    range_min: 0.4\n",
        "    range_max: 100\n", "    beams: 77\n", "    angle_min: -3.141592653589793\n",
        "    min_height: -0.1\n", "    # max_height: no limit\n", "    lost_after: 0.4\n",
        "    scan_destination_topic: m\n", "    base_frame: base\n",
        "    pose: {xyz: [0.1, -0.2, 2], rpy_deg: [1, -2, 30]}\n",
        "    angle_increment: 0.004363323129985824\n"}) {
    EXPECT_THAT(yaml, HasSubstr(line));
  }
}

TEST(ToYaml, WritesAPlanarScannersOwnKeys) {
  const std::string yaml = to_yaml(
      parse_config("sensors: {a: {model: sick_microscan3, angle_min: -1, publish_intensity: no}}", "f"));
  EXPECT_THAT(yaml,
              HasSubstr("    angle_min: -1\n    # angle_max: all beams\n    publish_intensity: false\n"));
}

TEST(ToYaml, KeepsAnyPose) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> turn(-180, 180);
  std::uniform_real_distribution<double> meters(-10, 10);
  for (int i = 0; i < 300; ++i) {
    Config config = parse_config("sensors: {a: {topic: s, pose: {xyz: [0, 0, 0]}}}", "f");
    const double pitch = i % 10 == 0 ? 90 : i % 10 == 1 ? -90 : turn(random) / 2;
    config.sensors[0].pose = make_pose({meters(random), meters(random), meters(random)},
                                       Eigen::Vector3d(turn(random), pitch, turn(random)) * (M_PI / 180));
    const std::string yaml = to_yaml(config);
    const Config again = parse_config(yaml, "g");
    EXPECT_TRUE(again.sensors[0].pose->isApprox(*config.sensors[0].pose, 1e-9)) << yaml;
    EXPECT_EQ(to_yaml(again), yaml);
  }
}

}  // namespace
}  // namespace lidard
