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
