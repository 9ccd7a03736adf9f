// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

SensorConfig sensor_of(const std::string& keys, const std::string& model = "velodyne_vlp16") {
  return parse_config("sensors: {a: {model: " + model + ", " + keys + "}}", "f").sensors.at(0);
}

TEST(CloudConfig, LeavesCloudsAsTheyComeUnlessAsked) {
  const SensorConfig a = sensor_of("ip_port: 2368");
  EXPECT_EQ(a.driver.cut_angle, 0);
  EXPECT_EQ(a.driver.min_range, 0);
  EXPECT_EQ(a.driver.max_range, 0);
  EXPECT_DOUBLE_EQ(a.driver.view_width, 2 * M_PI);
  EXPECT_TRUE(CloudArranger(a.layout).is_plain());
  EXPECT_FALSE(a.ring_scan);
  EXPECT_EQ(a.points_topic, "a/points");
  EXPECT_EQ(a.telemetry_port, 8308);
}

TEST(CloudConfig, TakesRangesAndTheViewInRadOrDegrees) {
  const SensorConfig a = sensor_of("min_range: 0.5, max_range: 60, view_direction_deg: -90, view_width: 1.5");
  EXPECT_EQ(a.driver.min_range, 0.5);
  EXPECT_EQ(a.driver.max_range, 60);
  EXPECT_DOUBLE_EQ(a.driver.view_direction, -M_PI / 2);
  EXPECT_EQ(a.driver.view_width, 1.5);
  EXPECT_DOUBLE_EQ(sensor_of("view_width_deg: 360").driver.view_width, 2 * M_PI);
  EXPECT_DOUBLE_EQ(sensor_of("view_width: 6.283185308").driver.view_width, 2 * M_PI)
      << "as velodyne_pointcloud writes it";
}

TEST(CloudConfig, ArrangesTheMessage) {
  const SensorConfig a = sensor_of("organize_cloud: true, frame_stamp: last");
  EXPECT_EQ(a.layout.order, CloudOrder::ring_rows);
  EXPECT_EQ(a.layout.stamp, FrameStamp::last);
  EXPECT_EQ(sensor_of("organize_cloud: rings").layout.order, CloudOrder::ring_rows);
  EXPECT_EQ(sensor_of("organize_cloud: firings").layout.order, CloudOrder::firing_rows);
  EXPECT_EQ(sensor_of("organize_cloud: no").layout.order, CloudOrder::list);
}

TEST(CloudConfig, FindsTheLevelRingOfEveryModel) {
  const std::pair<const char*, int> levels[] = {{"velodyne_vlp16", 8},   {"velodyne_puck_hires", 8},
                                                {"velodyne_vlp32c", 20}, {"velodyne_vlp32a", 16},
                                                {"velodyne_hdl32e", 23}, {"velodyne_vls128", 71}};
  for (const auto& [model, ring] : levels) {
    const SensorConfig a = sensor_of("scan_ring: auto", model);
    ASSERT_TRUE(a.ring_scan);
    EXPECT_EQ(a.ring_scan->ring, ring) << model;
  }
}

TEST(CloudConfig, MakesAPlanarScanOfAnyRing) {
  const SensorConfig a =
      sensor_of("scan_ring: 15, scan_resolution_deg: 0.4, max_range: 80, scan_topic: level, points_topic: p");
  ASSERT_TRUE(a.ring_scan);
  EXPECT_EQ(a.ring_scan->ring, 15);
  EXPECT_DOUBLE_EQ(a.ring_scan->resolution, 0.4 * M_PI / 180);
  EXPECT_EQ(a.ring_scan->range_min, 0.4);
  EXPECT_EQ(a.ring_scan->range_max, 80);
  EXPECT_TRUE(a.driver.keep_too_near);
  EXPECT_EQ(a.scan_topic, "level");
  EXPECT_EQ(a.points_topic, "p");
  EXPECT_FALSE(sensor_of("scan_ring: -1").ring_scan);
}

TEST(CloudConfig, ChoosesTheTelemetryPort) {
  EXPECT_EQ(sensor_of("telemetry_port: 8309").telemetry_port, 8309);
  EXPECT_EQ(sensor_of("telemetry_port: 0").telemetry_port, 0);
}

TEST(CloudConfig, TakesPacketsFromATopicInsteadOfTheNetwork) {
  const SensorConfig a = sensor_of("packet_topic: /velodyne_packets");
  EXPECT_EQ(a.packet_topic, "/velodyne_packets");
}

TEST(CloudConfig, PublishesPacketsOnATopicOfTheirOwn) {
  EXPECT_EQ(sensor_of("min_range: 1").raw_topic, "");
  const OutputTopic topic = sensor_topics(sensor_of("raw_topic: velodyne_packets")).at(1);
  EXPECT_EQ(topic.name, "velodyne_packets");
  EXPECT_EQ(topic.kind, TopicKind::message);
  EXPECT_EQ(topic.message, message_kind<RawPackets>());
}

TEST(CloudConfig, PlanarScannersHaveNoSuchKeysButTheirTopic) {
  EXPECT_EQ(sensor_of("scan_topic: front", "sick_microscan3").scan_topic, "front");
  EXPECT_EQ(sensor_of("ip_port: 6060", "sick_microscan3").scan_topic, "a/scan");
}

}  // namespace
}  // namespace lidard
