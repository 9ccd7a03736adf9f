// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

const std::string sensors =
    "sensors:\n"
    "  a: {model: sick_microscan3, pose: {xyz: [0, 1, 0]}}\n"
    "  b: {topic: /b/scan, pose: {xyz: [0, -1, 0]}}\n"
    "vehicle: {footprint: [[-1, -1], [1, -1], [1, 1]]}\n";

Config parse(const std::string& keys) {
  return parse_config(sensors + "merged_scans: {m: {" + keys + "}}\n", "f");
}
MergeOptions options(const std::string& keys) { return parse(keys).merged_scans.at(0).options; }
std::string error(const std::string& keys) {
  return test::error_of(sensors + "merged_scans: {m: {" + keys + "}}\n");
}

TEST(MergeOptionsConfig, AreCautiousByDefaultAndTakenByTheirNames) {
  const MergeOptions plain = options("laserscan_topics: a b, profile: strict");
  EXPECT_FALSE(plain.newest_wins);
  EXPECT_FALSE(plain.all_heights);
  EXPECT_FALSE(plain.veil_cross_check);
  EXPECT_EQ(plain.intensities, Intensities::automatic);
  const MergeOptions all = options(
      "laserscan_topics: a b, profile: strict, conflicts: newest, free_requires: all, veil_cross_check: "
      "true, "
      "intensity: on, missing_intensity: -1");
  EXPECT_TRUE(all.newest_wins);
  EXPECT_TRUE(all.all_heights);
  EXPECT_TRUE(all.veil_cross_check);
  EXPECT_EQ(all.intensities, Intensities::on);
  EXPECT_EQ(all.missing_intensity, -1);
  EXPECT_EQ(options("laserscan_topics: a b, intensity: off").intensities, Intensities::off);
}

TEST(MergeOptionsConfig, AreRefusedWhereTheyCanHaveNoEffect) {
  EXPECT_EQ(
      error("laserscan_topics: a b, conflicts: newest"),
      "f:5:43: merged_scans.m.conflicts has no effect with profile: flatten, which knows no free space; "
      "expected profile: strict or safety");
  EXPECT_EQ(
      error("laserscan_topics: a, profile: strict, free_requires: all"),
      "f:5:58: merged_scans.m.free_requires has no effect with one source; expected two sources or more");
  EXPECT_EQ(error("laserscan_topics: a, profile: safety, veil_cross_check: true"),
            "f:5:58: merged_scans.m.veil_cross_check has no effect with one source; expected two sources or "
            "more");
  EXPECT_EQ(
      error("laserscan_topics: a b, missing_intensity: 5"),
      "f:5:43: merged_scans.m.missing_intensity has no effect with intensity: auto; expected intensity: "
      "on");
  EXPECT_EQ(error("laserscan_topics: a b, intensity: maybe"),
            "f:5:54: merged_scans.m.intensity is \"maybe\"; expected auto, on or off");
  EXPECT_EQ(error("laserscan_topics: a b, conflicts: oldest"),
            "f:5:54: merged_scans.m.conflicts is \"oldest\"; expected keep or newest");
  EXPECT_EQ(error("laserscan_topics: a b, profile: strict, free_requires: some"),
            "f:5:75: merged_scans.m.free_requires is \"some\"; expected any or all");
}

TEST(MergeOptionsConfig, AreWrittenAndReadBack) {
  const Config config = parse(
      "laserscan_topics: a b, profile: strict, conflicts: newest, free_requires: all, veil_cross_check: "
      "true, "
      "intensity: on, missing_intensity: 0.25");
  const MergeOptions again = parse_config(to_yaml(config), "again").merged_scans.at(0).options;
  EXPECT_TRUE(again.newest_wins && again.all_heights && again.veil_cross_check);
  EXPECT_EQ(again.intensities, Intensities::on);
  EXPECT_EQ(again.missing_intensity, 0.25F);
}

}  // namespace
}  // namespace lidard
