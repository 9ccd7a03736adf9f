// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Entries are compared as values: a reload goes on with those that are equal.
#include <gtest/gtest.h>

#include <string>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

/// A vehicle, two sensors, a merged scan, a virtual scan and a merged cloud, with one place in its text
/// changed.
Config entries_with(const std::string& before = "", const std::string& after = "") {
  std::string text =
      "vehicle: {base_frame: base, footprint: [[-4, -1], [0.1, -1], [0.1, 1]]}\n"
      "sensors:\n"
      "  roof: {model: velodyne_vlp16, ip_address: 10.0.0.1, pose: {xyz: [0.1, -0.2, 2]}, max_range: 90}\n"
      "  rear: {topic: /rear/scan, frame_id: rear, pose: {xyz: [0, 0, 1]}}\n"
      "merged_scans:\n"
      "  m: {laserscan_topics: rear, range_max: 20, profile: strict, also: {s: safety}}\n"
      "merged_clouds:\n"
      "  c: {sources: [roof], deadline: 0.01}\n"
      "virtual_scans:\n"
      "  v: {cloud_topic: roof, virtual_laser_scan: [a], poses: {a: {xyz: [1, 2, 3]}}, beams: 77}\n";
  if (!before.empty()) text.replace(text.find(before), before.size(), after);
  return parse_config(text, "f");
}

/// Which entries are equal to those of the text as it is: vehicle, roof, rear, m, v, c.
std::string equal_ones(const Config& a) {
  const Config b = entries_with();
  const bool same[] = {a.vehicle == b.vehicle,
                       a.sensors[0] == b.sensors[0],
                       a.sensors[1] == b.sensors[1],
                       a.merged_scans[0] == b.merged_scans[0],
                       a.virtual_scans[0] == b.virtual_scans[0],
                       a.merged_clouds[0] == b.merged_clouds[0]};
  std::string text;
  for (const bool one : same) text += one ? '=' : 'x';
  return text;
}

TEST(Equality, AnEntryEqualsAnotherOneReadFromTheSameText) {
  EXPECT_EQ(equal_ones(entries_with()), "======");
}

TEST(Equality, AnotherValueOfAKeyMakesAnotherEntryOfItsOwnAlone) {
  EXPECT_EQ(equal_ones(entries_with("0.1, 1]", "0.2, 1]")), "x=====");
  EXPECT_EQ(equal_ones(entries_with("xyz: [0.1,", "xyz: [0.1000000001,")), "=x====");
  EXPECT_EQ(equal_ones(entries_with("max_range: 90", "max_range: 91")), "=x====");
  EXPECT_EQ(equal_ones(entries_with(", max_range: 90", "")), "=x====");
  EXPECT_EQ(equal_ones(entries_with("velodyne_vlp16", "velodyne_puck_lite")), "=x====");
  EXPECT_EQ(equal_ones(entries_with("frame_id: rear", "frame_id: stern")), "==x===");
  EXPECT_EQ(equal_ones(entries_with("s: safety", "s: flatten")), "===x==");
  EXPECT_EQ(equal_ones(entries_with("m: {", "n: {")), "===x==");
  EXPECT_EQ(equal_ones(entries_with("[1, 2, 3]", "[1, 2, 4]")), "====x=");
  EXPECT_EQ(equal_ones(entries_with("beams: 77", "beams: 78")), "====x=");
  EXPECT_EQ(equal_ones(entries_with("deadline: 0.01", "deadline: 0.02")), "=====x");
  EXPECT_EQ(equal_ones(entries_with("sources: [roof]", "sources: [roof], organize_cloud: true")), "=====x");
}

}  // namespace
}  // namespace lidard
