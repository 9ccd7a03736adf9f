// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What is said of mistakes, those that a configuration can have among them.
#include "daemon/offline/remarks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <regex>

#include "test/daemon/config/config_support.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// The error of a configuration, or its remarks, a line each.
std::string said_of(const std::string& text) {
  try {
    std::string all;
    const Config config = parse_config(text, "f");
    for (const auto& list : {remarks_on(config), host_remarks_on(config)})
      for (const std::string& remark : list) all += remark + "\n";
    return all;
  } catch (const ConfigError& error) {
    return error.what();
  }
}

struct Row {
  std::string text;
  std::string words;
};

std::string sensor(const std::string& keys) { return "sensors: {a: {" + keys + "}}\n"; }
std::string scanner(const std::string& keys) {
  return sensor("model: sick_microscan3, ip_address: 10.0.0.1, " + keys);
}
std::string tim(const std::string& keys) {
  return sensor("model: sick_tim7xx, ip_address: 10.0.0.1, " + keys);
}
std::string roof(const std::string& keys) { return sensor("model: velodyne_vlp16, " + keys); }
std::string pair_of(const std::string& one, const std::string& other) {
  return "sensors:\n  a: {model: sick_microscan3, ip_address: 10.0.0.1, " + one +
         "}\n  b: {model: sick_microscan3, ip_address: 10.0.0.2, " + other + "}\n";
}
std::string merged(const std::string& keys) {
  return pair_of("pose: {xyz: [1, 0, 0.3]}", "pose: {xyz: [0, 0, 0.3]}") +
         "merged_scans: {m: {laserscan_topics: [a, b], " + keys + "}}\n";
}
std::string virtual_scan(const std::string& keys) {
  return roof("pose: {xyz: [0, 0, 2]}") + "virtual_scans: {v: {cloud_topic: a, virtual_laser_scan: [low], " +
         keys + "}}\n";
}
std::string vehicle(const std::string& footprint) { return "vehicle: {footprint: " + footprint + "}\n"; }

const std::string wide = "[[-1, -2], [1, -2], [1, 2], [-1, 2]]";
const std::string truck = "[[-4, -1], [0, -1], [0, 1], [-4, 1]]";

class Mistake : public ::testing::TestWithParam<Row> {};

TEST_P(Mistake, IsSaidWithItsPlaceAndRemedy) {
  const std::string said = said_of(GetParam().text);
  EXPECT_THAT(said, HasSubstr(GetParam().words)) << GetParam().text;
  static const std::regex placed("(f:[1-9][0-9]*:[1-9][0-9]*: [^\n]+\n?)+");
  EXPECT_TRUE(std::regex_match(said, placed)) << said;
}

/// The letters of the words, and the row.
std::string name_of(const ::testing::TestParamInfo<Row>& info) {
  std::string name = "Row" + std::to_string(info.index);
  for (const char c : info.param.words.substr(0, 40))
    name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(
    OfGeometry, Mistake,
    ::testing::Values(
        Row{pair_of("pose: {xyz: [1, 0, 0.3]}", "pose: {xyz: [1, 0, 0.3]}"),
            "f:3:53: sensors.b.pose is that of sensors.a too: give each sensor the pose where it stands"},
        Row{pair_of("frame_id: laser", "frame_id: laser"),
            "f:3:53: sensors.b.frame_id has the frame of sensors.a, laser: give each sensor a frame of its "
            "own"},
        Row{pair_of("frame_id: b", "pose: {xyz: [1, 0, 0]}"), "sensors.b has the frame of sensors.a, b"},
        Row{scanner("pose: {xyz: [1, 0, 0.3], rpy_deg: [45, 0, 0]}"),
            "a.pose tilts a planar scanner by 45 deg: correct roll and pitch"},
        Row{scanner("pose: {xyz: [1, 0, 0.3], rpy_deg: [0, 10, 90]}"), "tilts a planar scanner by 10 deg"},
        Row{scanner("pose: {xyz: [1, 0, 0.3], rpy_deg: [90, 0, 0]}") +
                "merged_scans: {m: {laserscan_topics: [a]}}",
            "tilts a planar scanner by 90 deg"},
        Row{scanner("pose: {xyz: [1, 0, 0.3], rpy_deg: [170, 0, 0]}"), "tilts a planar scanner by 10 deg"},
        Row{scanner("pose: {xyz: [1, 0, -0.35]}"),
            "sensors.a.pose is 0.35 m below base_link; z counts upwards: is its sign right?"},
        Row{virtual_scan("poses: {low: {xyz: [0, 0, -0.5]}}"), "v.poses.low is 0.50 m below base_link"},
        Row{virtual_scan("base_frame: a, poses: {low: {xyz: [0, 0, -2.5]}}"), "v.poses.low is 0.50 m below"},
        Row{scanner("pose: {xyz: [900, 0, 350]}"), "is 966 m away; are its numbers in m, and not in mm?"},
        Row{merged("destination_frame: f, destination_pose: {xyz: [0, 30, 0]}"),
            "m.destination_pose is 30 m away"},
        Row{virtual_scan("poses: {low: {xyz: [0, 0, 50]}}"), "v.poses.low is 50 m away"},
        Row{vehicle(truck) + scanner("pose: {xyz: [4, 0, 0.3]}"),
            "sensors.a.pose is 4.0 m outside of vehicle.footprint; correct one of them"},
        Row{vehicle(truck) + scanner("pose: {xyz: [0.5, -3.9, 0.3]}"),
            "is 2.9 m outside of vehicle.footprint"},
        Row{vehicle(truck) + virtual_scan("poses: {low: {xyz: [12, 0, 0.3]}}"),
            "v.poses.low is 12.0 m outside"},
        Row{vehicle(wide) + scanner("pose: {xyz: [2, 1, 0.3]}"),
            "f:1:11: vehicle.footprint is wider than long, and sensors stand outside of it: are x (ahead) "
            "and "
            "y (left) swapped?"},
        Row{vehicle("[[-400, -100], [0, -100], [0, 100], [-400, 100]]") + scanner("frame_id: l"),
            "vehicle.footprint is 400 m long; are its numbers in m"},
        Row{pair_of("pose: {xyz: [1, 0, 0.2]}", "pose: {xyz: [0, 0, 0.6]}") +
                "merged_scans: {m: {laserscan_topics: [a, b], profile: safety}}",
            "m.laserscan_topics merges scanners 0.20 to 0.60 m high"},
        Row{merged("profile: strict"), "vehicle.footprint is not set"},
        Row{scanner("angle_min_deg: 150, angle_max_deg: -150"),
            "a.angle_min_deg begins a sector of 60 deg, of which only 0 are in the view of the "
            "scanner, -137.5 to 137.5 deg"},
        Row{merged("source_settings: {a: {angle_min_deg: 90, angle_max_deg: 270}}"),
            "m.source_settings.a.angle_min_deg begins a sector of 180 deg, of which only 94"},
        Row{tim("angle_min_deg: 140, angle_max_deg: 170"), "of which only 0 are in the view"},
        Row{merged("source_settings: {a: {range_min: 50}}"), "a.range_min is 50 m; is it meant in cm or mm?"},
        Row{roof("min_range: 200"), "a.min_range is 200 m; is it meant in cm or mm?"},
        Row{merged("policy: rate, rate: 100"),
            "m.rate is 100 per s, and its sources send 66.7 sweeps per s at most"},
        Row{roof("frame_id: l") + "merged_clouds: {c: {sources: [a], policy: rate, rate: 50}}",
            "c.rate is 50 per s, and its sources send 20 sweeps per s at most"}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    OfUnits, Mistake,
    ::testing::Values(
        Row{merged("deadline: 50"), "m.deadline is 50 s; is it meant in ms?"},
        Row{merged("lost_after: 400"), "m.lost_after is 400 s; is it meant in ms?"},
        Row{merged("scan_time: 33"), "m.scan_time is 33 s; is it meant in ms?"},
        Row{merged("time_increment: 0.15"), "m.time_increment is 0.15 s; is it meant in ms?"},
        Row{scanner("time_offset: 50"), "a.time_offset is 50 s; is it meant in ms?"},
        Row{scanner("time_offset: -20"), "a.time_offset is -20 s; is it meant in ms?"},
        Row{merged("angle_increment: 0.25"),
            "m.angle_increment is 0.25 rad; is it meant in degrees (angle_increment_deg)?"},
        Row{virtual_scan("angle_increment: 0.5"), "v.angle_increment is 0.5 rad"},
        Row{roof("filter: {voxel_size: 100}"), "a.filter.voxel_size is 100 m; is it meant in cm or mm?"},
        Row{merged("range_noise: 0.5"), "m.range_noise is 0.5 m"},
        Row{merged("range_min: 25"), "m.range_min is 25 m; is it meant in cm or mm?"},
        Row{merged("range_max: 8000"), "m.range_max is 8000 m; is it meant in mm?"},
        Row{roof("min_range: 90"), "a.min_range is 90 m; is it meant in cm or mm?"},
        Row{virtual_scan("profile: strict, ground: {model: plane, tolerance: 5}"),
            "v.ground.tolerance is 5 m"},
        Row{scanner("pose: {xyz: [1, 0, 0], rpy_deg: [0, 0, 1.5708]}"),
            "a.pose.rpy_deg looks like rad and is taken as degrees; in rad the key is rpy"},
        Row{merged("angle_min_deg: -2.356, angle_max_deg: 2.356"),
            "m.angle_max_deg looks like rad and is taken as degrees; in rad the key is angle_max"},
        Row{roof("view_width_deg: 3.1416"), "a.view_width_deg looks like rad"}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    OfNetworkAndModel, Mistake,
    ::testing::Values(
        Row{scanner("udp_receiver_ip: 203.0.113.5"),
            "a.udp_receiver_ip is 203.0.113.5, which is no address of this host"},
        Row{roof("ip_port: 368"), "a.ip_port is 368: ports below 1024 need privileges"},
        Row{roof("telemetry_port: 830"), "a.telemetry_port is 830: ports below 1024"},
        Row{roof("ip_address: 255.255.255.255"), "a.ip_address is 255.255.255.255, the address of no device"},
        Row{sensor("model: sick_lms1xx, ip_address: 0.0.0.0"),
            "the address of no device; set that of the sensor"},
        Row{sensor("model: velodyne_hdl64e_s1"),
            "f:1:15: sensors.a.model has no calibration: an HDL-64E S1 does not send its calibration"}),
    name_of);

std::string unknown(const std::string& key) { return roof(key + ": 1"); }

INSTANTIATE_TEST_SUITE_P(
    OfKeysOfOtherDrivers, Mistake,
    ::testing::Values(
        Row{unknown("port"), "unknown key sensors.a.port; expected ip_port"},
        Row{unknown("device_ip"), "unknown key sensors.a.device_ip; expected ip_address"},
        Row{unknown("hostname"), "unknown key sensors.a.hostname; expected ip_address"},
        Row{unknown("sensor_ip"), "expected ip_address"},
        Row{unknown("host_ip"), "expected udp_receiver_ip (SICK)"},
        Row{unknown("data_port"), "expected ip_port"}, Row{unknown("gnss_port"), "expected telemetry_port"},
        Row{unknown("laser_frame_id"), "expected frame_id"}, Row{unknown("sensor_model"), "expected model"},
        Row{unknown("xyz"), "expected pose: {xyz: [x, y, z], rpy_deg: [roll, pitch, yaw]}"},
        Row{unknown("rpm"), "expected control: {rpm"},
        Row{unknown("calibration_file"), "expected calibration"},
        Row{unknown("min_ang"), "expected angle_min"}, Row{unknown("pcap"), "`lidard replay --pcap FILE`"},
        Row{unknown("multicast_addr"), "expected multicast_group"},
        Row{merged("frame_id: b"), "unknown key merged_scans.m.frame_id; expected destination_frame"},
        Row{merged("output_topic: b"), "expected scan_destination_topic"},
        Row{merged("publish_rate: 5"), "unknown key merged_scans.m.publish_rate; expected rate"},
        Row{virtual_scan("target_frame: b"), "expected virtual_laser_scan"},
        Row{"lidars: {a: {}}", "f:1:1: unknown key lidars; expected sensors"},
        Row{"vehicle: {robot_frame: b}\n" + scanner("frame_id: b"),
            "vehicle.robot_frame; expected base_frame"},
        Row{roof("filter: {type: 1}"), "unknown key sensors.a.filter.type; expected one of"}),
    name_of);

INSTANTIATE_TEST_SUITE_P(
    OfYaml, Mistake,
    ::testing::Values(Row{"sensors:\n  a: {model: velodyne_vlp16\n  b: {topic: t}\n",
                          "f:3:4: not YAML: the { of line 2 is not closed"},
                      Row{"sensors:\n  a: {model: velodyne_vlp16, pose: {xyz: [1, 2, 3}}\n",
                          "the [ of line 2 is not closed"},
                      Row{"sensors:\n  a: {topic: \"[\"}\nvehicle\n  x: 1\n",
                          "f:4:4: not YAML: line 3 has no key"},
                      Row{"sensors:\n  # {\n  a: {model: b, pose: {xyz: [1, 2, 3]}\nvehicle:\n  x: 1\n",
                          "the { of line 3 is not closed"},
                      Row{"sensors:\n  roof\n    model: velodyne_vlp16\n",
                          "f:3:10: not YAML: line 2 has no key with a colon and a blank behind it"},
                      Row{"sensors:\n  a:\n    model:velodyne_vlp16\n\n    ip_port: 3\n",
                          "f:5:12: not YAML: line 3 has no key"},
                      Row{"sensors:\n  a: x\n    model: velodyne_vlp16\n",
                          "its indentation does not go with line 2, which has a value already"},
                      Row{"sensors:\n  a:\n    model: velodyne_vlp16\n   ip_port: 3\n",
                          "f:4:4: not YAML: its indentation does not go with line 3; expected"}),
    name_of);

TEST(Remarks, AreMadeOfACalibrationOfAnotherModel) {
  LIDARD_NEED_CAPTURE(file, std::string("calibration/VLP16_hires.yaml"));
  EXPECT_THAT(
      said_of(roof("calibration: " + file)),
      HasSubstr("a.calibration has elevations up to 5.0 deg off those of VLP-16, and fits Puck Hi-Res: "
                "is it the right file?"));
  EXPECT_THAT(said_of(sensor("model: velodyne_puck_hires, calibration: " + file)), IsEmpty());
}

TEST(Remarks, OnTheNetworkOfThisHostAreForTheCommandsThatUseIt) {
  for (const std::string& text : {scanner("udp_receiver_ip: 203.0.113.5"), roof("ip_port: 368")}) {
    const Config config = parse_config(text, "f");
    EXPECT_THAT(remarks_on(config), IsEmpty()) << "replay, snapshot and calibrate show these";
    EXPECT_EQ(host_remarks_on(config).size(), 1U) << text;
  }
}

/// What is right, or may be.
TEST(Remarks, AreNotMadeOfWhatMayBeMeant) {
  for (const std::string& text :
       {pair_of("pose: {xyz: [1, 0, 0.3]}", "pose: {xyz: [1, 0, 0.3], rpy_deg: [0, 0, 180]}"),
        std::string(
            "sensors: {a: {topic: s, pose: {xyz: [1, 0, 0]}}, b: {topic: t, pose: {xyz: [1, 0, 0]}}}\n"
            "merged_scans: {m: {laserscan_topics: [a, b]}}\n"),
        scanner("pose: {xyz: [1, 0, 0.3], rpy_deg: [180, 1.5, 5.5]}"),
        scanner("pose: {xyz: [1, 0, 0.3], rpy_deg: [90, 0, 0]}"),
        scanner("pose: {xyz: [1, 0, -0.2]}"),
        scanner("time_offset: 37"),
        scanner("time_offset: -7200"),
        scanner("time_offset: 0.05"),
        scanner("udp_receiver_ip: 127.0.0.1"),
        scanner("udp_receiver_ip: 239.0.0.1"),
        scanner("udp_receiver_ip: 0.0.0.0"),
        scanner("angle_min_deg: -140, angle_max_deg: 140"),
        scanner("angle_min: 0, angle_max: 6.2832"),
        scanner("angle_min: -3.14, angle_max: 3.14"),
        scanner("angle_min_deg: 0, angle_max_deg: 180"),
        scanner("angle_min: 0.5"),
        scanner("pose: {xyz: [9, 0, 0.3], rpy_deg: [0.2, 1.57, 90]}"),
        scanner("pose: {xyz: [1, 0, 0.3], rpy: [0, 0, 1.5708]}"),
        roof("ip_address: 10.0.0.0"),
        vehicle(truck) + scanner("pose: {xyz: [0.5, 1.3, 0.3]}"),
        vehicle(wide) + scanner("pose: {xyz: [0.9, 1.9, 0]}"),
        vehicle(truck) + virtual_scan("poses: {low: {xyz: [7, 0, 0.3]}}"),
        virtual_scan("base_frame: a, poses: {low: {xyz: [0, 0, -1.7]}}"),
        merged("destination_frame: base_footprint, destination_pose: {xyz: [0, 0, -0.5]}"),
        merged("policy: rate, rate: 50"),
        merged("angle_increment_deg: 1, lost_after: 5, deadline: 1"),
        sensor("model: sick_tim7xx, ip_address: 10.0.0.1, ip_port: 80"),
        scanner("pose: {xyz: [1, 0, 0.3], rpy_deg: [0, 8, 0]}") +
            "merged_scans: {m: {laserscan_topics: [a], min_height: -0.2}}\n"})
    EXPECT_EQ(said_of(text), "") << text;
}

}  // namespace
}  // namespace lidard
