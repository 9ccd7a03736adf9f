// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/offline/remarks.h"
#include "drivers/registry/registry.h"
#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using test::error_of;
using ::testing::HasSubstr;
using ::testing::StartsWith;

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

TEST(SensorConfig, RefusesAFileWithoutSensors) {
  const std::string expected = "; expected sensors: with at least one entry, each with model: or topic:";
  EXPECT_EQ(error_of(""), "f:1:1: the file has no sensors" + expected);
  EXPECT_EQ(error_of("vehicle: {base_frame: base}\n"), "f:1:1: the file has no sensors" + expected);
  EXPECT_EQ(error_of("vehicle: {}\nsensors:\n"), "f:2:1: sensors is empty" + expected);
  EXPECT_EQ(error_of("sensors: {}\n"), "f:1:10: sensors is empty" + expected);
}

TEST(SensorConfig, RefusesNeitherAndBothOfModelAndTopic) {
  EXPECT_EQ(error_of("sensors:\n  a:\n    frame_id: x\n"),
            "f:2:3: sensors.a has neither model nor topic; expected model: a name from `lidard models`, or "
            "topic:");
  EXPECT_EQ(error_of("sensors:\n  a:\n    model: velodyne_vlp16\n    topic: scan\n"),
            "f:4:5: sensors.a.topic is given beside model; expected one of them: model (our driver) or topic "
            "(another driver)");
}

TEST(SensorConfig, NamesTheNearestModels) {
  EXPECT_EQ(error_of("sensors:\n  a: {model: velodyne_vlp61}\n"),
            "f:2:14: sensors.a.model is \"velodyne_vlp61\", which is no model; expected velodyne_vlp16 or "
            "velodyne_vlp32a or velodyne_vlp32b; see "
            "`lidard models`");
  EXPECT_EQ(error_of("sensors:\n  a: {model: qqqqqqqqqqqq}\n"),
            "f:2:14: sensors.a.model is \"qqqqqqqqqqqq\", which is no model; expected a name from `lidard "
            "models`");
}

TEST(SensorConfig, RefusesWhatIsNoSenderAddress) {
  const std::string usual = "the sensor's IPv4 address like 192.168.1.201";
  EXPECT_EQ(error_of("sensors:\n  a:\n    model: velodyne_vlp16\n    ip_address: 192.168.1.256\n"),
            "f:4:17: sensors.a.ip_address is \"192.168.1.256\", which is no address; expected " + usual);
  EXPECT_EQ(error_of("sensors: {a: {model: velodyne_vlp16, ip_address: 239.0.0.1}}"),
            "f:1:50: sensors.a.ip_address is \"239.0.0.1\", a multicast group; expected " + usual +
                "; the group goes into multicast_group");
  EXPECT_EQ(error_of("sensors: {a: {model: velodyne_vlp16, ip_address: 'fd00:64::201'}}"),
            "f:1:50: sensors.a.ip_address is \"fd00:64::201\", an IPv6 address, from which nothing is "
            "received; expected " +
                usual);
  EXPECT_EQ(error_of("sensors: {a: {model: velodyne_vlp16, multicast_group: 10.0.0.1}}"),
            "f:1:55: sensors.a.multicast_group is \"10.0.0.1\", which is no multicast group; expected a "
            "multicast address like 239.0.0.10");
  EXPECT_EQ(error_of("sensors: {a: {model: velodyne_vlp16, interface: eth0}}"),
            "f:1:38: sensors.a.interface is given without multicast_group; expected both: the interface is "
            "where the group is joined");
}

TEST(SensorConfig, RefusesPortsThatDoNotExist) {
  const std::string expected = "; expected a whole number from 1 to 65535";
  const std::string begin = "sensors: {a: {model: velodyne_vlp16, ip_port: ";
  EXPECT_EQ(error_of(begin + "0}}"), "f:1:47: sensors.a.ip_port is 0" + expected);
  EXPECT_EQ(error_of(begin + "65536}}"), "f:1:47: sensors.a.ip_port is 65536" + expected);
  EXPECT_EQ(error_of(begin + "2368.5}}"), "f:1:47: sensors.a.ip_port is \"2368.5\"" + expected);
  EXPECT_EQ(error_of(begin + "abc}}"), "f:1:47: sensors.a.ip_port is \"abc\"" + expected);
  EXPECT_EQ(error_of(begin + "}}"), "f:1:38: sensors.a.ip_port is empty" + expected);
}

TEST(SensorConfig, RefusesSensorsThatNothingTellsApart) {
  EXPECT_EQ(
      error_of("sensors:\n"
               "  a: {model: velodyne_vlp16, ip_address: 10.0.0.1}\n"
               "  b: {model: velodyne_vlp16, ip_address: 10.0.0.1}\n"),
      "f:3:42: sensors.b.ip_address and port 2368 are those of sensors.a too; expected another ip_address "
      "or ip_port for each sensor");
  EXPECT_EQ(error_of("sensors:\n  s: {model: sick_lms1xx, ip_address: 10.0.0.1}\n"
                     "  a: {model: velodyne_vlp16}\n  b: {model: velodyne_vlp16}\n"),
            "f:4:3: sensors.b and sensors.a share port 2368 without ip_address, so nothing tells them apart; "
            "expected ip_address for at least one of them");
}

TEST(SensorConfig, SharesAPortBetweenSendersThatDiffer) {
  EXPECT_EQ(error_of("sensors:\n"
                     "  a: {model: velodyne_vlp16, ip_address: 10.0.0.1}\n"
                     "  b: {model: velodyne_vlp16, ip_address: 10.0.0.2}\n"
                     "  c: {model: velodyne_vlp16}\n"
                     "  d: {model: velodyne_vlp16, ip_address: 10.0.0.1, ip_port: 2369}\n"),
            "no error");
}

TEST(SensorConfig, RefusesKeysThatTheModelCannotHonour) {
  const auto error = [](const char* model, const char* key) {
    return error_of(std::string("sensors:\n  a:\n    model: ") + model + "\n    " + key + "\n");
  };
  EXPECT_EQ(
      error("velodyne_vlp16", "angle_min: 0"),
      "f:4:5: sensors.a.angle_min is not available for velodyne_vlp16, only for planar scanners; expected no "
      "such key; of a Velodyne view_direction and view_width keep a sector");
  EXPECT_EQ(error("velodyne_vlp16", "calibrate_time: true"),
            "f:4:5: sensors.a.calibrate_time is not available for velodyne_vlp16, only for Hokuyos that "
            "speak SCIP; "
            "expected clock: smooth, which follows the device clock all the time");
  EXPECT_EQ(
      error("sick_microscan3", "skip: 1"),
      "f:4:5: sensors.a.skip is not available for sick_microscan3, only for SICK scanners that speak CoLa, "
      "Hokuyos that speak SCIP; expected no such key; set it up in the device");
  for (const char* key : {"publish_multiecho: true", "cluster: 2", "publish_intensity: true"})
    EXPECT_THAT(error("velodyne_vlp16", key), HasSubstr("is not available for velodyne_vlp16"));
  EXPECT_THAT(error("sick_microscan3", "cut_angle: 1"),
              HasSubstr("only for Velodynes; expected no such key"));
}

TEST(SensorConfig, TakesAWindowThroughStraightBehindAndRefusesOneWithoutWidth) {
  const Config config =
      parse_config("sensors: {a: {model: sick_microscan3, angle_min: 2.5, angle_max: -2.5}}", "f");
  const Sector sector = config.sensors[0].driver.sector();
  EXPECT_TRUE(sector.holds(pi_d));
  EXPECT_TRUE(sector.holds(-2.6));
  EXPECT_FALSE(sector.holds(0));
  EXPECT_EQ(error_of("sensors: {a: {model: sick_microscan3, angle_min_deg: 10, angle_max_deg: 10}}"),
            "f:1:73: sensors.a.angle_max_deg is a sector of no width; expected angle_min and angle_max of a "
            "sector, counter-clockwise");
}

TEST(SensorConfig, RefusesDeviceKeysBesideATopic) {
  EXPECT_EQ(error_of("sensors:\n  a:\n    topic: /scan\n    ip_port: 2368\n"),
            "f:4:5: sensors.a.ip_port does not apply to a source with topic:; expected topic, frame_id, pose "
            "and time_offset only");
}

TEST(SensorConfig, RefusesNamesThatRosWouldRefuse) {
  EXPECT_EQ(
      error_of("sensors:\n  front-left: {model: velodyne_vlp16}\n"),
      "f:2:3: sensors.front-left cannot be part of a topic name; expected a letter, then letters, digits "
      "and underscores");
  for (const std::string topic :
       {"'1scan'", "a//b", "scan/", "'my scan'", "'~'", "/", "'~scan'", "'~/scan'"}) {
    EXPECT_THAT(error_of("sensors: {a: {topic: " + topic + "}}"), StartsWith("f:1:22: sensors.a.topic is "));
  }
  EXPECT_EQ(error_of("sensors: {a: {topic: scan, frame_id: 'my frame'}}"),
            "f:1:38: sensors.a.frame_id is \"my frame\"; expected the name of a tf frame, without blanks");
}

TEST(SensorConfig, RefusesPosesThatAreNone) {
  const std::string begin = "sensors:\n  a:\n    model: velodyne_vlp16\n    pose: ";
  const std::string three = "; expected a list of 3 numbers in ";
  EXPECT_EQ(error_of(begin + "[0, 0, 0]\n"),
            "f:4:11: sensors.a.pose is a list; expected a mapping (`key: value` lines)");
  EXPECT_EQ(error_of(begin + "{rpy: [0, 0, 0]}\n"),
            "f:4:5: sensors.a.pose has no xyz; expected {xyz: [x, y, z], rpy_deg: [roll, pitch, yaw]}");
  EXPECT_EQ(error_of(begin + "{xyz: [0, 0]}\n"), "f:4:17: sensors.a.pose.xyz has 2 elements" + three + "m");
  EXPECT_EQ(error_of(begin + "{xyz: 5}\n"), "f:4:17: sensors.a.pose.xyz is \"5\"" + three + "m");
  EXPECT_EQ(error_of(begin + "{xyz: [0, .nan, 0]}\n"),
            "f:4:21: sensors.a.pose.xyz[1] is \".nan\"; expected a number from -1000 to 1000 m");
  EXPECT_EQ(error_of(begin + "{xyz: [0, 0, 1e999]}\n"),
            "f:4:24: sensors.a.pose.xyz[2] is \"1e999\"; expected a number from -1000 to 1000 m");
  EXPECT_EQ(error_of(begin + "{xyz: [0, inf, 0]}\n"),
            "f:4:21: sensors.a.pose.xyz[1] is not finite; expected a number from -1000 to 1000 m");
  EXPECT_EQ(
      error_of(begin + "{xyz: [0, 0, 0], rpy: [0, 0, 45]}\n"),
      "f:4:40: sensors.a.pose.rpy[2] is 45; expected a number from -6.284 to 6.284 rad (degrees: rpy_deg)");
  EXPECT_EQ(error_of(begin + "{xyz: [0, 0, 0], rpy: [0, 0, 0], rpy_deg: [0, 0, 0]}\n"),
            "f:4:44: sensors.a.pose.rpy_deg is given beside rpy; expected one of the two");
}

TEST(SensorConfig, RefusesTwoPosesForOneFrame) {
  EXPECT_EQ(error_of("sensors:\n"
                     "  a: {topic: s, frame_id: f, pose: {xyz: [0, 0, 1]}}\n"
                     "  b: {topic: t, frame_id: f, pose: {xyz: [0, 0, 2]}}\n"),
            "f:3:36: sensors.b.pose differs from the pose of frame f in sensors.a; expected one pose for one "
            "frame");
  EXPECT_EQ(error_of("sensors:\n  a: {topic: s, frame_id: base_link, pose: {xyz: [0, 0, 1]}}\n"),
            "f:2:44: sensors.a.pose moves base_link against itself; expected no pose, or another frame");
  EXPECT_EQ(error_of("sensors:\n  a: {model: velodyne_vlp16, frame_id: roof, pose: {xyz: [0, 0, 2]}}\n"
                     "virtual_scans:\n  v: {cloud_topic: a, base_frame: roof, virtual_laser_scan: base_link, "
                     "output_laser_topic: low, poses: {base_link: {xyz: [0, 0, -2]}}}\n"),
            "f:4:116: virtual_scans.v.poses.base_link places base_link in roof, which the pose of roof in "
            "sensors.a places in base_link; expected poses that lead from each frame up to "
            "vehicle.base_frame");
}

TEST(SensorConfig, RefusesUnknownWordsAndTimes) {
  EXPECT_EQ(error_of("sensors: {a: {model: velodyne_vlp16, clock: gps}}"),
            "f:1:45: sensors.a.clock is \"gps\"; expected smooth or arrival");
  EXPECT_EQ(error_of("sensors: {a: {model: velodyne_vlp16, time_offset: 2e6}}"),
            "f:1:51: sensors.a.time_offset is 2e+06; expected a number from -1e+06 to 1e+06 s");
  EXPECT_EQ(error_of("sensors: {a: {model: sick_microscan3, publish_intensity: maybe}}"),
            "f:1:58: sensors.a.publish_intensity is \"maybe\"; expected true or false");
  EXPECT_EQ(error_of("sensors: {a: {model: velodyne_vlp16, cut_angle: 90}}"),
            "f:1:49: sensors.a.cut_angle is 90; expected a number from -6.284 to 6.284 rad (degrees: "
            "cut_angle_deg)");
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

TEST(SensorConfig, RefusesWhatAHokuyoCannotDo) {
  const std::string head = "sensors: {a: {model: hokuyo_ust_10lx, ip_address: 10.0.0.1, ";
  EXPECT_EQ(error_of(head + "skip: 10}}"),
            "f:1:67: sensors.a.skip is 10; expected a whole number from 0 to 9");
  EXPECT_NE(error_of(head + "cluster: 0}}"), "no error");
  EXPECT_NE(error_of(head + "publish_multiecho: true}}"), "no error") << "it has one echo";
  EXPECT_NE(error_of("sensors: {a: {model: hokuyo_uam_05lp, ip_address: 10.0.0.1, skip: 1}}"), "no error");
}

TEST(SensorConfig, WarnsOfATopicSourceThatNobodyUses) {
  const Config config = parse_config("sensors:\n  rear: {topic: /rear/scan}\n", "f");
  EXPECT_EQ(config.warnings,
            std::vector<std::string>{"f:2:3: sensors.rear is used by no merged and no virtual scan"});
}

TEST(SensorConfig, OfATcpDeviceNeedsItsAddressAndNoMulticast) {
  EXPECT_EQ(error_of("sensors:\n  front: {model: hokuyo_ust_10lx}\n"),
            "f:2:3: sensors.front has no ip_address; expected the device's address: it is read over TCP, so "
            "somebody has to connect to it");
  const Config config =
      parse_config("sensors: {front: {model: hokuyo_ust_10lx, ip_address: 192.168.0.10}}", "f");
  EXPECT_EQ(config.sensors[0].ip_port, 10940);
  EXPECT_THAT(error_of("sensors:\n  front:\n    model: hokuyo_ust_10lx\n    ip_address: 192.168.0.10\n"
                       "    multicast_group: 239.0.0.1\n"),
              StartsWith("f:5:5: sensors.front.multicast_group is not available for hokuyo_ust_10lx, only "
                         "for devices that stream over UDP"));
}

TEST(SensorConfig, TellsTcpDevicesApartByAddressAndPort) {
  const std::string one =
      "sensors:\n  a: {model: hokuyo_ust_10lx, ip_address: 192.168.0.10, ip_port: 2368}\n";
  EXPECT_THAT(error_of(one + "  b: {model: hokuyo_ust_10lx, ip_address: 192.168.0.10, ip_port: 2368}\n"),
              testing::HasSubstr("and port 2368 are those of sensors.a too"));
  EXPECT_EQ(error_of(one + "  b: {model: hokuyo_ust_10lx, ip_address: 192.168.0.10}\n"), "no error");
  EXPECT_EQ(error_of(one + "  b: {model: velodyne_vlp16, ip_address: 192.168.0.10, ip_port: 2368}\n"),
            "no error");
}

}  // namespace
}  // namespace lidard
