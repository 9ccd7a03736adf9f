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
using ::testing::IsEmpty;

SensorConfig sensor_of(const NodeParameters& parameters) {
  return parse_config(velodyne_node_setup(parameters).keys.yaml(), "p").sensors.at(0);
}

std::string error_of(const NodeParameters& parameters) {
  try {
    sensor_of(parameters);
    return "no error";
  } catch (const ConfigError& error) {
    return error.what();
  }
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

TEST(VelodyneNode, AppliesEveryParameterThatHasAMeaningHere) {
  const DropinSetup setup = velodyne_node_setup({{"model", "VLS128"},
                                                 {"device_ip", "192.168.1.201"},
                                                 {"port", "2370"},
                                                 {"frame_id", "roof"},
                                                 {"rpm", "600"},
                                                 {"cut_angle", "1.5"},
                                                 {"timestamp_first_packet", "true"},
                                                 {"time_offset", "-0.02"},
                                                 {"min_range", "0.4"},
                                                 {"max_range", "200"},
                                                 {"view_direction", "0.5"},
                                                 {"view_width", "3"},
                                                 {"organize_cloud", "true"},
                                                 {"laserscan_ring", "60"},
                                                 {"laserscan_resolution", "0.0035"},
                                                 {"pcap", ""}});
  EXPECT_THAT(setup.warnings, IsEmpty());
  EXPECT_THAT(setup.replay.captures, IsEmpty());
  const SensorConfig sensor = parse_config(setup.keys.yaml(), "p").sensors.at(0);
  EXPECT_EQ(sensor.ip_address, IpAddress::v4(192, 168, 1, 201));
  EXPECT_EQ(sensor.ip_port, 2370);
  EXPECT_EQ(sensor.frame_id, "roof");
  EXPECT_EQ(sensor.driver.cut_angle, 1.5);
  EXPECT_EQ(sensor.layout.stamp, FrameStamp::first);
  EXPECT_EQ(sensor.driver.time_offset, std::chrono::milliseconds(-20));
  EXPECT_EQ(sensor.driver.min_range, 0.4);
  EXPECT_EQ(sensor.driver.max_range, 200);
  EXPECT_EQ(sensor.driver.view_direction, 0.5);
  EXPECT_EQ(sensor.driver.view_width, 3);
  EXPECT_EQ(sensor.layout.order, CloudOrder::firing_rows);
  EXPECT_EQ(sensor.ring_scan->ring, 60);
  EXPECT_EQ(sensor.ring_scan->resolution, 0.0035);
}

TEST(VelodyneNode, PublishesPacketsWhereAskedTo) {
  EXPECT_EQ(sensor_of({{"model", "VLP16"}}).raw_topic, "velodyne_packets") << "as velodyne_driver does";
  EXPECT_EQ(sensor_of({{"model", "VLP16"}, {"publish_packets", "false"}}).raw_topic, "");
  EXPECT_EQ(sensor_of({{"model", "VLP16"}, {"packet_topic", "velodyne_packets"}}).raw_topic, "");
  EXPECT_THAT(velodyne_node_setup({{"publish_packets", "true"}}).warnings, IsEmpty());
}

TEST(VelodyneNode, PublishesInTheFrameThatItIsAskedFor) {
  const auto config_of = [](NodeParameters parameters) {
    parameters["model"] = "VLP16";
    parameters["frame_id"] = "roof";
    return parse_config(velodyne_node_setup(parameters).keys.yaml(), "p");
  };
  const Config none = config_of({{"fixed_frame", ""}, {"target_frame", ""}});
  EXPECT_EQ(none.sensors[0].points_frame, "");
  EXPECT_FALSE(none.sensors[0].deskew || none.vehicle.has_motion());
  const Config target = config_of({{"target_frame", "/base"}});
  EXPECT_EQ(target.sensors[0].points_frame, "base");
  EXPECT_FALSE(target.sensors[0].deskew || target.vehicle.has_motion());
  const Config fixed = config_of({{"fixed_frame", "odom"}});
  EXPECT_EQ(fixed.sensors[0].points_frame, "odom") << "as datacontainerbase.h, finishCloud()";
  EXPECT_TRUE(fixed.sensors[0].deskew);
  const Config both = config_of({{"fixed_frame", "/odom"}, {"target_frame", "base"}});
  EXPECT_EQ(both.sensors[0].points_frame, "base");
  EXPECT_TRUE(both.sensors[0].deskew);
  EXPECT_EQ(both.vehicle.odometry_frame, "odom");
  EXPECT_EQ(both.vehicle.base_frame, "roof") << "no frame has to be known but these";
  const Config itself = config_of({{"fixed_frame", "/roof"}});
  EXPECT_EQ(itself.sensors[0].points_frame, "roof");
  EXPECT_FALSE(itself.sensors[0].deskew);
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

TEST(VelodyneNode, TakesPacketsThatVelodyneDriverPublishes) {
  EXPECT_EQ(sensor_of({{"model", "VLP16"}, {"packet_topic", "velodyne_packets"}}).packet_topic,
            "velodyne_packets");
}

TEST(VelodyneNode, SaysWhatHasNoEffectAndWhatIsUnknown) {
  const auto warnings = velodyne_node_setup({{"model", "VLP16"},
                                             {"rpm", "1200"},
                                             {"fixed_frame", ""},
                                             {"gps_time", "false"},
                                             {"target_frame", ""},
                                             {"max_rang", "50"}})
                            .warnings;
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_THAT(warnings[0], HasSubstr("~rpm (1200) has no effect: revolutions are seen"));
  EXPECT_EQ(warnings[1], "parameter ~max_rang is not known and has no effect; did you mean ~max_range?");
}

TEST(VelodyneNode, RefusesValuesThatMeanNothing) {
  EXPECT_THAT(error_of({{"model", "VLP17"}}),
              HasSubstr("~model is 'VLP17', which lidard does not support; expected one of VLP16, 32C"));
  EXPECT_EQ(error_of({{"model", "VLP16"}, {"max_range", "far"}}),
            "parameter ~max_range is 'far'; expected a number");
  EXPECT_EQ(error_of({{"model", "VLP16"}, {"read_once", "maybe"}}),
            "parameter ~read_once is 'maybe'; expected true or false");
  EXPECT_THAT(error_of({{"model", "VLP16"}, {"device_ip", "roof"}}),
              HasSubstr("sensors.velodyne.ip_address is"));
  EXPECT_THAT(error_of({{"model", "VLP16"}, {"laserscan_ring", "1.5"}}), HasSubstr("scan_ring is \"1.5\""));
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
