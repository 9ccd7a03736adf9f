// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "daemon/config/config.h"
#include "daemon/dropin/dropin.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/calibration.h"

namespace lidard {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

SensorConfig sensor_of(const NodeParameters& parameters) {
  return parse_config(velodyne_node_setup(parameters).keys.yaml(), "p").sensors.at(0);
}

TEST(VelodyneNode, HasTheDefaultsOfTheNodesItStandsInFor) {
  const SensorConfig sensor = sensor_of({{"model", "VLP16"}});
  EXPECT_EQ(sensor.model, find_model("velodyne_vlp16"));
  EXPECT_EQ(sensor.ip_port, 2368);
  EXPECT_FALSE(sensor.ip_address);
  EXPECT_EQ(sensor.telemetry_port, 0);
  EXPECT_EQ(sensor.frame_id, "velodyne");
  EXPECT_EQ(sensor.points_topic, "velodyne_points");
  EXPECT_EQ(sensor.scan_topic, "scan");
  EXPECT_EQ(sensor.layout.stamp, FrameStamp::last);
  EXPECT_EQ(sensor.layout.order, CloudOrder::list);
  EXPECT_EQ(sensor.driver.min_range, 0.9);
  EXPECT_EQ(sensor.driver.max_range, 130);
  EXPECT_DOUBLE_EQ(sensor.driver.view_width, 2 * M_PI);
  ASSERT_TRUE(sensor.ring_scan);
  EXPECT_EQ(sensor.ring_scan->ring, 8);
  EXPECT_EQ(sensor.ring_scan->resolution, 0.007);
  ASSERT_NE(sensor.driver.calibration, nullptr);
  EXPECT_EQ(own_calibration(sensor.driver)->model, CalibrationModel::ros_drivers);
  EXPECT_DOUBLE_EQ(sensor.driver.cut_angle, M_PI);
}

TEST(VelodyneNode, KnowsTheModelsUnderTheirOldNames) {
  const std::pair<const char*, const char*> names[] = {{"VLP16", "velodyne_vlp16"},
                                                       {"32C", "velodyne_vlp32c"},
                                                       {"32E", "velodyne_hdl32e"},
                                                       {"VLS128", "velodyne_vls128"},
                                                       {"64E", "velodyne_hdl64e_s1"},
                                                       {"64E_S2", "velodyne_hdl64e_s2"},
                                                       {"64E_S2.1", "velodyne_hdl64e_s21"},
                                                       {"64E_S3", "velodyne_hdl64e_s3"},
                                                       {"velodyne_vlp32a", "velodyne_vlp32a"}};
  for (const auto& [theirs, ours] : names) EXPECT_EQ(sensor_of({{"model", theirs}}).model, find_model(ours));
  EXPECT_EQ(sensor_of({}).model, find_model("velodyne_hdl64e_s1")) << "as velodyne_driver";
  EXPECT_THAT(
      velodyne_node_setup({{"model", "VLP16"}, {"calibration", "/x/VLP16_hires_db.yaml"}}).keys.yaml(),
      HasSubstr("model: velodyne_puck_hires"));
}

TEST(VelodyneNode, PlaysACaptureAsVelodyneDriverDoes) {
  const ReplayOptions forever = velodyne_node_setup({{"model", "VLP16"}, {"pcap", "a.pcap"}}).replay;
  EXPECT_THAT(forever.captures, ElementsAre("a.pcap"));
  EXPECT_TRUE(forever.loop);
  EXPECT_TRUE(forever.restamp);
  EXPECT_EQ(forever.rate, 1);
  const ReplayOptions once = velodyne_node_setup({{"model", "VLP16"},
                                                  {"pcap", "a.pcap"},
                                                  {"read_once", "true"},
                                                  {"read_fast", "1"},
                                                  {"repeat_delay", "2.5"},
                                                  {"pcap_time", "true"}})
                                 .replay;
  EXPECT_FALSE(once.loop);
  EXPECT_FALSE(once.restamp);
  EXPECT_EQ(once.rate, 0);
  EXPECT_EQ(once.loop_gap, std::chrono::milliseconds(2500));
}

TEST(VelodyneNode, TakesNoViewForTheWholeTurnAndARingThatThereIsNotForTheLevelOne) {
  const SensorConfig plain = sensor_of({{"model", "VLP16"}});
  const SensorConfig odd = sensor_of({{"model", "VLP16"}, {"view_width", "0"}, {"laserscan_ring", "16"}});
  EXPECT_EQ(odd.driver.view_width, plain.driver.view_width);
  EXPECT_EQ(odd.ring_scan->ring, plain.ring_scan->ring);
}

TEST(VelodyneNode, IsNamedLikeAnyNode) {
  unsetenv("ROS_NAMESPACE");
  EXPECT_EQ(full_node_name({}, "velodyne_node"), "/velodyne_node");
  EXPECT_EQ(full_node_name({"__name:=velodyne", "_rpm:=600"}, "velodyne_node"), "/velodyne");
  EXPECT_EQ(full_node_name({"__ns:=/car/", "__name:=velodyne"}, "velodyne_node"), "/car/velodyne");
  setenv("ROS_NAMESPACE", "truck", 1);
  EXPECT_EQ(full_node_name({}, "velodyne_node"), "/truck/velodyne_node");
  unsetenv("ROS_NAMESPACE");
}

}  // namespace
}  // namespace lidard
