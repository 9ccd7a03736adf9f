// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "drivers/config_error.h"
#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using test::error_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;
using ::testing::StartsWith;

std::vector<std::string> errors_of(const std::string& text) {
  std::istringstream all(error_of(text));
  std::vector<std::string> lines;
  for (std::string line; std::getline(all, line);) lines.push_back(line);
  return lines;
}

TEST(Mistakes, OfAFileAreToldAtOnceInTheOrderOfItsLines) {
  EXPECT_THAT(errors_of("merged_scans:\n"
                        "  m:\n"
                        "    laserscan_topics: [left, right]\n"
                        "    profil: strict\n"
                        "    beams: 1\n"
                        "sensors:\n"
                        "  left: {model: sick_microscan3, ip_port: 99999, clock: slow}\n"
                        "  right: {topic: right/scan, pose: {xyz: [0, 1], rpy: 3}}\n"
                        "vehicle: {base_fram: base}\n"),
              ElementsAre("f:4:5: unknown key merged_scans.m.profil; expected profile",
                          "f:5:12: merged_scans.m.beams is 1; expected a whole number from 2 to 32767",
                          "f:7:43: sensors.left.ip_port is 99999; expected a whole number from 1 to 65535",
                          "f:7:57: sensors.left.clock is \"slow\"; expected smooth or arrival",
                          "f:8:42: sensors.right.pose.xyz has 2 elements; expected a list of 3 numbers in m",
                          "f:9:11: unknown key vehicle.base_fram; expected base_frame"));
}

TEST(Mistakes, AreNoReasonToComplainOfWhatFollowsFromThem) {
  // An unknown model, whose name, scans and topics others use.
  EXPECT_THAT(
      errors_of("sensors:\n"
                "  front: {model: sick_microscan9}\n"
                "  rear: {topic: rear}\n"
                "virtual_scans: {v: {cloud_topic: front, virtual_laser_scan: [chest]}}\n"
                "merged_scans:\n"
                "  m: {laserscan_topics: [front, rear], trigger: front}\n"
                "  n: {laserscan_topics: [front/scan, chest], range_min: 50}\n"),
      ElementsAre(StartsWith("f:2:18: sensors.front.model is \"sick_microscan9\", which is no model")));
  // A misspelt key that something else needs.
  EXPECT_THAT(
      errors_of("sensors: {a: {topic: s}}\nmerged_scans: {m: {laserscan_topic: [a], policy: trigger}}\n"),
      ElementsAre(HasSubstr("unknown key merged_scans.m.laserscan_topic; expected laserscan_topics")));
  // A value that cannot be read and that a rule would compare with another.
  EXPECT_THAT(errors_of("sensors: {a: {topic: s}}\n"
                        "merged_scans: {m: {laserscan_topics: [a], angle_min: x, angle_max: -3.5}}\n"),
              ElementsAre(HasSubstr("m.angle_min is \"x\"")));
  // A misspelt section, and a value that a rule of another section needs.
  EXPECT_THAT(errors_of("sensor: {a: {topic: s}}\nmerged_scans: {m: {laserscan_topics: [a]}}\n"),
              ElementsAre("f:1:1: unknown key sensor; expected sensors"));
  EXPECT_THAT(errors_of("vehicle: {odometry_frame: a b}\n"
                        "sensors: {a: {model: velodyne_vlp16, deskew: true}}\n"),
              ElementsAre(HasSubstr("vehicle.odometry_frame is \"a b\"")));
}

TEST(Mistakes, AreAllRulesThatAnEntryBreaks) {
  EXPECT_THAT(
      errors_of("sensors: {a: {topic: s}}\n"
                "merged_scans:\n"
                "  m:\n"
                "    laserscan_topics: [a, b]\n"
                "  n:\n"
                "    laserscan_topics: [a]\n"
                "    min_height: 2\n"
                "    max_height: 1\n"
                "    rate: 5\n"
                "    policy: trigger\n"),
      ElementsAre(StartsWith("f:4:27: merged_scans.m.laserscan_topics[1] names \"b\", which is no sensor"),
                  StartsWith("f:8:17: merged_scans.n.max_height leaves no height"),
                  StartsWith("f:9:5: merged_scans.n.rate has no effect with policy: trigger")));
}

TEST(Mistakes, OfModelsThatAreNotKnownAreCheckedAsFarAsAnyModelGoes) {
  EXPECT_THAT(
      errors_of("sensors: {a: {model: nothing, ip_port: 0, skip: 1000, time_offset: x, qqqqqqqqqqqq: 1}}\n"),
      SizeIs(5));
}

TEST(Mistakes, EndAtTwenty) {
  std::string text = "sensors:\n";
  for (int i = 0; i < 30; ++i)
    text += "  s" + std::to_string(i) + ": {topic: t" + std::to_string(i) + ", clok: 1}\n";
  const auto lines = errors_of(text);
  ASSERT_THAT(lines, SizeIs(21));
  EXPECT_THAT(lines[19], StartsWith("f:21:"));
  EXPECT_EQ(lines[20], "f: 10 more mistakes; expected these to be corrected first");
}

TEST(Mistakes, AreToldOnceEach) {
  EXPECT_THAT(errors_of("sensors: {a: {topic: s, topic: t, topic: u}}\n"), SizeIs(2));
  EXPECT_THAT(errors_of("sensors: {a: {model: velodyne_vlp16, control: {port: 1, port: 2}}}\n"), SizeIs(1));
}

}  // namespace
}  // namespace lidard
