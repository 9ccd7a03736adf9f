// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using test::error_of;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string sensor = "sensors: {roof: {model: velodyne_vlp16}}\n";

std::string load_error(const std::string& path) {
  try {
    load_config(path);
    return "no error";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

TEST(Config, UnknownKeysNameTheNearestKnownOne) {
  EXPECT_EQ(error_of("sensor: {}\n"), "f:1:1: unknown key sensor; expected sensors");
  EXPECT_EQ(error_of("sensors:\n  a:\n    modle: velodyne_vlp16\n"),
            "f:3:5: unknown key sensors.a.modle; expected model");
  EXPECT_EQ(error_of("sensors:\n  a:\n    ip_adress: 10.0.0.1\n"),
            "f:3:5: unknown key sensors.a.ip_adress; expected ip_address");
  EXPECT_EQ(error_of("vehicle: {basefame: b}\n"),
            "f:1:11: unknown key vehicle.basefame; expected base_frame");
  EXPECT_EQ(test::merged_error("angle_incrementdeg: 1"),
            "f:7:7: unknown key merged_scans.m.angle_incrementdeg; expected angle_increment_deg");
}

TEST(Config, AMergeKeyBringsTheKeysOfAnotherMapping) {
  const Config config = parse_config(
      "sensors:\n"
      "  a: &a {topic: /a, frame_id: x, time_offset: 0.5}\n"
      "  b: &b {<<: *a, topic: /b}\n"
      "  c: {topic: /c, <<: [{frame_id: y}, *b]}\n",
      "f");
  ASSERT_EQ(config.sensors.size(), 3U);
  EXPECT_EQ(config.sensors[1].topic, "/b") << "what is written out counts more";
  EXPECT_EQ(config.sensors[1].frame_id, "x");
  EXPECT_EQ(config.sensors[2].topic, "/c");
  EXPECT_EQ(config.sensors[2].frame_id, "y") << "the first of several counts more";
  EXPECT_EQ(config.sensors[2].driver.time_offset, span_from_seconds(0.5));
}

TEST(Config, AMergeKeyThatGoesRoundInCirclesOrGrowsWithoutEndIsRefused) {
  EXPECT_EQ(error_of("sensors:\n  a: &a {<<: *a, topic: /a}\n"),
            "f:2:14: an alias stands for the list or mapping that it is a part of; expected one that ends "
            "before it");
  std::string text = "sensors:\n  s0: &s0 {topic: /s}\n";
  for (int i = 1; i < 9; ++i) {
    const std::string below = "*s" + std::to_string(i - 1);
    text += "  s" + std::to_string(i) + ": &s" + std::to_string(i) + " {<<: [" + below + ", " + below + ", " +
            below + "]}\n";
  }
  EXPECT_THAT(error_of(text), HasSubstr("merges more than 100 mappings"));
}

TEST(Config, AFileInUtf16IsNamedAsSuch) {
  using namespace std::string_literals;
  EXPECT_EQ(error_of("\xFF\xFEs\0e\0"s),
            "f:1:1: the file is UTF-16; expected UTF-8 (`iconv -f UTF-16 -t UTF-8`, or another encoding when "
            "saving)");
  EXPECT_THAT(error_of("s"), Not(HasSubstr("UTF-16"))) << "a single character";
}

TEST(Config, UnknownKeysNearNothingListWhatThereIs) {
  EXPECT_EQ(error_of("qqqqqq: 1\n"),
            "f:1:1: unknown key qqqqqq; expected one of vehicle, sensors, merged_scans, merged_clouds, "
            "virtual_scans, "
            "blackbox");
  EXPECT_EQ(
      error_of("<>: {}\n"),
      "f:1:1: unknown key <>; expected one of vehicle, sensors, merged_scans, merged_clouds, virtual_scans, "
      "blackbox");
}

TEST(Config, KeysGivenTwiceAreAnError) {
  EXPECT_EQ(error_of("sensors:\n  a:\n    topic: s\n    topic: t\n"),
            "f:4:5: sensors.a.topic is given twice, first in line 3; expected it once");
  EXPECT_EQ(error_of("sensors:\n  a: {topic: s}\n  a: {topic: t}\n"),
            "f:3:3: sensors.a is given twice, first in line 2; expected it once");
}

TEST(Config, SyntaxErrorsNameTheirPlace) {
  const std::string expected = "; expected `key: value` lines, indented with blanks";
  EXPECT_EQ(error_of("sensors: [1, 2\n"), "f:2:1: not YAML: the [ of line 1 is not closed" + expected);
  EXPECT_EQ(error_of("sensors:\n  a: {topic: s}}\n"), "f:2:16: not YAML: illegal flow end" + expected);
  EXPECT_EQ(error_of("sensors:\n\ta: 1\n"), "f:2:3: not YAML: a tab in the indentation" + expected);
  // yaml-cpp 0.8 adds the name of the anchor.
  EXPECT_THAT(error_of("sensors: *a\n"),
              testing::AllOf(testing::StartsWith("f:1:10: not YAML: the referenced anchor is not defined"),
                             testing::EndsWith(expected)));
}

TEST(Config, WrongShapesNameTheirPlace) {
  const std::string mapping = "; expected a mapping (`key: value` lines)";
  EXPECT_EQ(error_of("just text\n"), "f:1:1: the file is \"just text\"" + mapping);
  EXPECT_EQ(error_of("- a\n- b\n"), "f:1:1: the file is a list" + mapping);
  EXPECT_EQ(error_of("sensors: [a]\n"), "f:1:10: sensors is a list" + mapping);
  EXPECT_EQ(error_of("sensors:\n  roof: velodyne_vlp16\n"),
            "f:2:9: sensors.roof is \"velodyne_vlp16\"" + mapping);
  EXPECT_EQ(error_of("? [a]\n: b\n"),
            "f:1:3: a key of the file is not a name; expected a name before the colon");
  EXPECT_EQ(error_of(sensor + "---\n" + sensor),
            "f:2:1: a second YAML document begins, or what is no YAML; expected one document per file");
  EXPECT_EQ(error_of(",\n"),
            "f:1:1: a second YAML document begins, or what is no YAML; expected one document per file");
}

TEST(Config, AnEmptySectionIsNoSection) {
  const Config config = parse_config(sensor + "vehicle:\nmerged_scans:\nvirtual_scans: {}\n", "f");
  EXPECT_TRUE(config.merged_scans.empty());
  EXPECT_TRUE(config.virtual_scans.empty());
}

TEST(Config, AnchorsMayShareValues) {
  const Config config = parse_config(
      "sensors:\n"
      "  a: {model: velodyne_vlp16, ip_address: 10.0.0.1, pose: &p {xyz: [0, 0, 2]}}\n"
      "  b: {model: velodyne_vlp16, ip_address: 10.0.0.2, pose: *p}\n",
      "f");
  EXPECT_TRUE(config.sensors.at(0).pose->isApprox(*config.sensors.at(1).pose));
}

TEST(Config, LongAndUnprintableTextIsShortenedInMessages) {
  EXPECT_EQ(error_of("sensors: {a: {model: velodyne_vlp16, clock: \"a\\tb" + std::string(100, 'x') + "\"}}"),
            "f:1:45: sensors.a.clock is \"a?b" + std::string(37, 'x') + "…\"; expected smooth or arrival");
}

TEST(VehicleConfig, TakesItsKeys) {
  const Config config = parse_config(
      sensor + "vehicle: {base_frame: /base, odometry_frame: odom, footprint: [[0, 0], [1, 0], [0, 1]]}",
      "f");
  EXPECT_EQ(config.vehicle.base_frame, "base");
  EXPECT_EQ(config.vehicle.odometry_frame, "odom");
  ASSERT_EQ(config.vehicle.footprint.size(), 3U);
  EXPECT_EQ(config.vehicle.footprint[2], Eigen::Vector2d(0, 1));
}

TEST(VehicleConfig, RefusesFootprintsThatAreNoPolygon) {
  const auto footprint = [](const std::string& list) {
    return error_of("vehicle: {footprint: " + list + "}\n" + sensor);
  };
  const std::string vertices = "; expected a list of 3 to 1000 vertices [x, y] in m";
  const std::string order = "; expected vertices in order around the vehicle, each once";
  EXPECT_EQ(footprint("5"), "f:1:22: vehicle.footprint is \"5\"" + vertices);
  EXPECT_EQ(footprint("[[0, 0], [1, 1]]"), "f:1:22: vehicle.footprint has 2 vertices" + vertices);
  EXPECT_EQ(footprint("[[0, 0], [1, 1], [2]]"),
            "f:1:39: vehicle.footprint[2] has 1 elements; expected a list of 2 numbers in m");
  EXPECT_EQ(footprint("[[0, 0], [1, 1], [2, x]]"),
            "f:1:43: vehicle.footprint[2][1] is \"x\"; expected a number from -1000 to 1000 m");
  EXPECT_EQ(footprint("[[0, 0], [1, 1], [1, 0], [0, 1]]"),
            "f:1:22: vehicle.footprint crosses itself or has no area" + order);
  EXPECT_EQ(footprint("[[0, 0], [1, 0], [1, 1], [0, 0]]"),
            "f:1:23: vehicle.footprint[0] is the same point as its neighbour; expected each vertex once");
  EXPECT_EQ(footprint("[[0, 0], [2, 0], [2, 2], [1, 0], [0, 2]]"),
            "f:1:22: vehicle.footprint crosses itself or has no area at (1, 0)" + order);
  EXPECT_EQ(footprint("[[0, 0], [1, 1], [2, 2]]"),
            "f:1:22: vehicle.footprint crosses itself or has no area at (2, 2)" + order);
  EXPECT_EQ(footprint("[[0, 0], [1e-3, 0], [0, 1e-3]]"), "f:1:22: vehicle.footprint has no area" + vertices);
  EXPECT_EQ(footprint("[[0, 0], [2, 0], [2, 2], [1, 0.5], [0, 2]]"), "no error");
  EXPECT_EQ(footprint("[]"), "no error");
}

TEST(VehicleConfig, RefusesOdometryThatMovesWithTheVehicle) {
  EXPECT_EQ(error_of("vehicle: {base_frame: odom, odometry_frame: odom}\n" + sensor),
            "f:1:45: vehicle.odometry_frame is base_frame too; expected the frame that stands still, usually "
            "odom");
}

TEST(VehicleConfig, RefusesAnOdometryFrameThatHangsFromTheVehicle) {
  EXPECT_THAT(error_of("vehicle: {odometry_frame: odom}\n"
                       "sensors: {a: {model: velodyne_vlp16, frame_id: odom, pose: {xyz: [0, 0, 1]}}}\n"),
              testing::HasSubstr("places odom in base_link, which the pose of base_link in "
                                 "vehicle.odometry_frame places in odom"));
}

TEST(LoadConfig, FilesThatCannotBeReadSayWhy) {
  EXPECT_EQ(load_error("/nowhere/lidard.yaml"),
            "/nowhere/lidard.yaml: cannot be read: No such file or directory; expected a readable YAML file");
  EXPECT_EQ(load_error("/"), "/: cannot be read: Is a directory; expected a readable YAML file");
  EXPECT_EQ(load_error("/dev/zero"), "/dev/zero: is larger than 1 MiB; expected a readable YAML file");
  EXPECT_THAT(load_error("/dev/null"), StartsWith("/dev/null:1:1: the file has no sensors; "));
}

TEST(LoadConfig, MessagesNameTheFile) {
  const std::string path = ::testing::TempDir() + "lidard_config_" + std::to_string(getpid()) + ".yaml";
  std::ofstream(path) << "sensors: 5\n";
  EXPECT_EQ(load_error(path), path + ":1:10: sensors is \"5\"; expected a mapping (`key: value` lines)");
  std::ofstream(path) << sensor;
  EXPECT_EQ(load_config(path).file, path);
  std::remove(path.c_str());
}

}  // namespace
}  // namespace lidard
