// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using test::error_of;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// The roof sensor with these keys in flow style; they begin at column 38.
std::string roof_cloud(const std::string& keys, const std::string& model = "velodyne_vlp16") {
  return "sensors: {a: {model: " + model + ", " + keys + "}}";
}

SensorConfig sensor_of(const std::string& keys, const std::string& model = "velodyne_vlp16") {
  return parse_config(roof_cloud(keys, model), "f").sensors.at(0);
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

TEST(CloudConfig, RefusesRangesAndViewsThatHoldNothing) {
  EXPECT_EQ(error_of(roof_cloud("min_range: 5, max_range: 5")),
            "f:1:63: sensors.a.max_range is not above min_range; expected min_range < max_range, or 0 for no "
            "limit");
  EXPECT_THAT(error_of(roof_cloud("min_range: -1")), StartsWith("f:1:49: sensors.a.min_range is -1"));
  EXPECT_EQ(error_of(roof_cloud("view_width: 0")),
            "f:1:50: sensors.a.view_width is no width of a sector; expected an angle in (0, 2 pi]");
  EXPECT_THAT(error_of(roof_cloud("view_width_deg: 361")),
              StartsWith("f:1:54: sensors.a.view_width_deg is no"));
  EXPECT_THAT(error_of(roof_cloud("view_direction_deg: 400")),
              HasSubstr("view_direction_deg is more than a turn"));
}

TEST(CloudConfig, RemovedKeysNameWhatToDoInstead) {
  for (const char* key : {"frame_duration", "publish_confidence", "publish_echo"})
    EXPECT_THAT(error_of(roof_cloud(std::string(key) + ": true")), HasSubstr("is a key of former versions"))
        << key;
  for (const char* key : {"laser", "phase_lock", "read", "save", "period"})
    EXPECT_THAT(
        error_of(roof_cloud("ip_address: 10.0.0.1, control: {" + std::string(key) + ": 1}")),
        HasSubstr("control." + std::string(key) + " is a key of former versions; expected no such key: "))
        << key;
}

TEST(CloudConfig, ArrangesTheMessage) {
  const SensorConfig a = sensor_of("organize_cloud: true, frame_stamp: last");
  EXPECT_EQ(a.layout.order, CloudOrder::ring_rows);
  EXPECT_EQ(a.layout.stamp, FrameStamp::last);
  EXPECT_EQ(sensor_of("organize_cloud: rings").layout.order, CloudOrder::ring_rows);
  EXPECT_EQ(sensor_of("organize_cloud: firings").layout.order, CloudOrder::firing_rows);
  EXPECT_EQ(sensor_of("organize_cloud: no").layout.order, CloudOrder::list);
  EXPECT_THAT(error_of(roof_cloud("organize_cloud: columns")),
              StartsWith("f:1:54: sensors.a.organize_cloud is"));
  EXPECT_EQ(error_of(roof_cloud("frame_stamp: middle")),
            "f:1:51: sensors.a.frame_stamp is \"middle\"; expected one of first, last");
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
  EXPECT_THAT(error_of(roof_cloud("scan_ring: 16")),
              StartsWith("f:1:49: sensors.a.scan_ring is 16; expected"));
  EXPECT_EQ(error_of(roof_cloud("scan_resolution: 0.007")),
            "f:1:38: sensors.a.scan_resolution is given without scan_ring; expected both, or neither");
  EXPECT_THAT(error_of(roof_cloud("scan_ring: 1, scan_resolution: 0.0001")), HasSubstr("is out of range"));
}

TEST(CloudConfig, GivesEveryTopicToOneOwner) {
  const std::string two =
      "sensors:\n"
      "  a: {model: velodyne_vlp16, points_topic: velodyne_points}\n"
      "  b: {model: velodyne_vlp16, ip_port: 2369, telemetry_port: 0, points_topic: ";
  EXPECT_THAT(error_of(two + "velodyne_points}\n"), HasSubstr("would publish on velodyne_points"));
  EXPECT_EQ(error_of(two + "other_points}\n"), "no error");
  EXPECT_THAT(error_of("sensors: {a: {model: velodyne_vlp16, scan_ring: auto, scan_topic: a/points}}"),
              HasSubstr("would publish on a/points"));
}

TEST(CloudConfig, ChoosesTheTelemetryPort) {
  EXPECT_EQ(sensor_of("telemetry_port: 8309").telemetry_port, 8309);
  EXPECT_EQ(sensor_of("telemetry_port: 0").telemetry_port, 0);
  EXPECT_EQ(error_of(roof_cloud("telemetry_port: 2368")),
            "f:1:54: sensors.a.telemetry_port is both ip_port and telemetry_port; expected two ports, or "
            "telemetry_port: 0");
  EXPECT_THAT(error_of(roof_cloud("telemetry_port: 8308", "velodyne_hdl64e_s3")),
              HasSubstr("only for devices with a satellite receiver"));
}

TEST(CloudConfig, TakesPacketsFromATopicInsteadOfTheNetwork) {
  const SensorConfig a = sensor_of("packet_topic: /velodyne_packets");
  EXPECT_EQ(a.packet_topic, "/velodyne_packets");
  EXPECT_THAT(error_of(roof_cloud("packet_topic: p, ip_port: 2368")),
              HasSubstr("sensors.a.ip_port is given beside packet_topic"));
  EXPECT_THAT(error_of(roof_cloud("packet_topic: p, control: {port: 80}")), HasSubstr("is given beside"));
  EXPECT_THAT(error_of(roof_cloud("packet_topic: p", "sick_microscan3")),
              HasSubstr("is not available for sick_microscan3, only for Velodynes"));
  EXPECT_EQ(
      error_of("sensors:\n  a: {model: velodyne_vlp16, packet_topic: p}\n  b: {model: velodyne_vlp16}\n"),
      "no error")
      << "no port is shared";
}

TEST(CloudConfig, PublishesPacketsOnATopicOfTheirOwn) {
  EXPECT_EQ(sensor_of("min_range: 1").raw_topic, "");
  const OutputTopic topic = sensor_topics(sensor_of("raw_topic: velodyne_packets")).at(1);
  EXPECT_EQ(topic.name, "velodyne_packets");
  EXPECT_EQ(topic.kind, TopicKind::message);
  EXPECT_EQ(topic.message, message_kind<RawPackets>());
  EXPECT_THAT(error_of(roof_cloud("raw_topic: a/points")), HasSubstr("would publish on a/points"));
  EXPECT_NE(error_of(roof_cloud("raw_topic: p, packet_topic: p")), "no error") << "it would hear itself";
  EXPECT_THAT(error_of(roof_cloud("raw_topic: p", "sick_microscan3")),
              HasSubstr("is not available for sick_microscan3, only for Velodynes"));
}

TEST(CloudConfig, PlanarScannersHaveNoSuchKeysButTheirTopic) {
  EXPECT_THAT(error_of(roof_cloud("min_range: 1", "sick_microscan3")),
              HasSubstr("is not available for sick_microscan3, only for Velodynes"));
  EXPECT_EQ(sensor_of("scan_topic: front", "sick_microscan3").scan_topic, "front");
  EXPECT_EQ(sensor_of("ip_port: 6060", "sick_microscan3").scan_topic, "a/scan");
}

}  // namespace
}  // namespace lidard
