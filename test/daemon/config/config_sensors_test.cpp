// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/offline/remarks.h"
#include "drivers/registry/registry.h"
#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

TEST(SensorConfig, GetsItsDefaultsFromTheModelAndItsName) {
  const Config config = parse_config("sensors: {roof: {model: velodyne_vlp16}}", "f");
  ASSERT_EQ(config.sensors.size(), 1U);
  const SensorConfig& roof = config.sensors[0];
  EXPECT_EQ(roof.name, "roof");
  EXPECT_EQ(roof.frame_id, "roof");
  EXPECT_EQ(roof.model, find_model("velodyne_vlp16"));
  EXPECT_EQ(roof.ip_port, 2368);
  EXPECT_FALSE(roof.ip_address);
  EXPECT_FALSE(roof.pose);
  EXPECT_EQ(roof.driver.model, roof.model);
  EXPECT_EQ(roof.driver.frame_id, "roof");
  EXPECT_EQ(roof.driver.clock, ClockMode::smooth);
  EXPECT_EQ(roof.driver.time_offset, Span(0));
  EXPECT_EQ(config.vehicle.base_frame, "base_link");
  EXPECT_TRUE(remarks_on(config).empty());
}

TEST(SensorConfig, TakesEveryKeyOfACloudSensor) {
  const Config config = parse_config(
      "sensors:\n"
      "  roof:\n"
      "    model: velodyne_vlp16\n"
      "    ip_address: 192.168.1.201\n"
      "    ip_port: 2400\n"
      "    frame_id: /velodyne\n"
      "    pose: {xyz: [1, 2, 3], rpy: [0, 0, 1.5]}\n"
      "    multicast_group: 239.0.0.10\n"
      "    interface: eth1\n"
      "    clock: arrival\n"
      "    time_offset: -0.25\n"
      "    cut_angle_deg: 90\n",
      "f");
  const SensorConfig& roof = config.sensors.at(0);
  EXPECT_EQ(roof.ip_address, IpAddress::v4(192, 168, 1, 201));
  EXPECT_EQ(roof.ip_port, 2400);
  EXPECT_EQ(roof.frame_id, "velodyne");
  ASSERT_TRUE(roof.pose);
  EXPECT_TRUE(roof.pose->isApprox(make_pose({1, 2, 3}, {0, 0, 1.5})));
  EXPECT_EQ(roof.multicast_group, IpAddress::v4(239, 0, 0, 10));
  EXPECT_EQ(roof.interface, "eth1");
  EXPECT_EQ(roof.driver.clock, ClockMode::arrival);
  EXPECT_EQ(roof.driver.time_offset, std::chrono::milliseconds(-250));
  EXPECT_DOUBLE_EQ(roof.driver.cut_angle, M_PI / 2);
}

TEST(SensorConfig, TakesEveryKeyOfAPlanarScanner) {
  const Config config = parse_config(
      "sensors: {front: {model: sick_microscan3, angle_min_deg: -90, angle_max: 1.5, publish_intensity: "
      "False}}",
      "f");
  const DriverConfig& driver = config.sensors.at(0).driver;
  EXPECT_DOUBLE_EQ(driver.angle_min.value(), -M_PI / 2);
  EXPECT_DOUBLE_EQ(driver.angle_max.value(), 1.5);
  EXPECT_FALSE(driver.publish_intensity);
}

TEST(SensorConfig, SensorOnTheBaseFrameNeedsNoPose) {
  const Config config = parse_config("sensors: {a: {model: velodyne_vlp16, frame_id: base_link}}", "f");
  ASSERT_TRUE(config.sensors.at(0).pose);
  EXPECT_TRUE(config.sensors[0].pose->isApprox(Pose::Identity()));
}

TEST(SensorConfig, TakesAWindowThroughStraightBehind) {
  const Config config =
      parse_config("sensors: {a: {model: sick_microscan3, angle_min: 2.5, angle_max: -2.5}}", "f");
  const Sector sector = config.sensors[0].driver.sector();
  EXPECT_TRUE(sector.holds(pi_d));
  EXPECT_TRUE(sector.holds(-2.6));
  EXPECT_FALSE(sector.holds(0));
}

TEST(SensorConfig, TakesEveryKeyOfAHokuyo) {
  const Config config = parse_config(
      "sensors: {a: {model: hokuyo_utm_30lx_ew, ip_address: 192.168.0.10, skip: 3, cluster: 2, "
      "publish_multiecho: true, calibrate_time: false}, b: {model: hokuyo_ust_10lx, ip_address: 10.0.0.1}}",
      "f");
  const DriverConfig& driver = config.sensors.at(0).driver;
  EXPECT_EQ(driver.requests.skip, 3);
  EXPECT_EQ(driver.requests.cluster, 2);
  EXPECT_TRUE(driver.publish_multiecho);
  EXPECT_FALSE(driver.requests.calibrate_time);
  EXPECT_EQ(config.sensors[0].ip_port, 10940);
  EXPECT_TRUE(config.sensors[1].driver.requests.calibrate_time);
  const std::string yaml = to_yaml(config);
  EXPECT_EQ(to_yaml(parse_config(yaml, "g")), yaml);
}

TEST(SensorConfig, WarnsOfATopicSourceThatNobodyUses) {
  const Config config = parse_config("sensors:\n  rear: {topic: /rear/scan}\n", "f");
  EXPECT_EQ(config.warnings,
            std::vector<std::string>{"f:2:3: sensors.rear is used by no merged and no virtual scan"});
}

TEST(SensorConfig, OfASickThatSpeaksColaAsksForNothingUnlessTold) {
  const Config config = parse_config("sensors: {a: {model: sick_lms1xx, ip_address: 192.168.0.1}}", "f");
  const DeviceRequests& requests = config.sensors.at(0).driver.requests;
  EXPECT_FALSE(requests.allow_write);
  EXPECT_FALSE(requests.device_states);
  EXPECT_FALSE(requests.skip.has_value());
  EXPECT_EQ(config.sensors[0].ip_port, 2112);
  for (const std::string model : {"sick_lms5xx", "sick_mrs1000"}) {
    const Config told = parse_config(
        "sensors: {a: {model: " + model + ", ip_address: 192.168.0.1, skip: 2, publish_states: true}}", "f");
    EXPECT_EQ(told.sensors.at(0).driver.requests.skip, 2);
    EXPECT_TRUE(told.sensors[0].driver.requests.device_states);
  }
}

}  // namespace
}  // namespace lidard
