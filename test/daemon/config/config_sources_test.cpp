// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What laserscan_topics, cloud_topic, trigger and source_settings may name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/offline/remarks.h"
#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(ConfigSources, FindsSourcesByNameAndByTopic) {
  const std::string sensors =
      "sensors: {a: {model: sick_microscan3}, b: {topic: /b_scan}, c: {topic: c_scan}}\nmerged_scans: {m: "
      "{laserscan_topics: ";
  const auto names = [&](const std::string& list) {
    return parse_config(sensors + list + "}}", "f").merged_scans.at(0).laserscan_topics;
  };
  EXPECT_THAT(names("[a, b, c]"), ElementsAre("a", "b", "c"));
  EXPECT_THAT(names("/a /b_scan  c"), ElementsAre("a", "b", "c"));
  EXPECT_THAT(names("[/a/scan, b_scan, /c_scan]"), ElementsAre("a", "b", "c"));
}

TEST(ConfigSources, FindsASensorByTheTopicThatItReallyPublishes) {
  const std::string sensors =
      "sensors: {front: {model: sick_microscan3, scan_topic: front_scan}, back: {model: sick_microscan3, "
      "ip_port: 6061, scan_topic: /vehicle/back}, roof: {model: velodyne_vlp16, scan_ring: auto, scan_topic: "
      "level}}\n";
  const auto names = [&](const std::string& list, const std::string& keys = "") {
    const Config config =
        parse_config(sensors + "merged_scans: {m: {laserscan_topics: [" + list + "]" + keys + "}}", "f");
    return config.merged_scans.at(0).laserscan_topics;
  };
  EXPECT_THAT(names("front_scan"), ElementsAre("front"));
  EXPECT_THAT(names("/front_scan, vehicle/back, /level"), ElementsAre("front", "back", "roof"));
  EXPECT_THAT(names("front, /vehicle/back"), ElementsAre("front", "back"));
}

TEST(ConfigSources, TriggerAndSettingsOfASourceTakeTheNamesOfItsList) {
  const std::string begin =
      "sensors: {front: {model: sick_microscan3, scan_topic: front_scan}, back: {model: sick_microscan3, "
      "ip_port: 6061}}\nmerged_scans: {m: {laserscan_topics: [back, /front_scan], ";
  for (const char* name : {"/front_scan", "front"}) {
    const Config config =
        parse_config(begin + "trigger: " + name + ", source_settings: {" + name + ": {range_max: 7}}}}", "f");
    const MergedScanConfig& merged = config.merged_scans.at(0);
    EXPECT_EQ(merged.schedule.trigger, 1U) << name;
    ASSERT_EQ(merged.source_settings.count("front"), 1U) << name;
    EXPECT_EQ(merged.source_settings.at("front").range_max, 7) << name;
    EXPECT_EQ(to_yaml(parse_config(to_yaml(config), "again")), to_yaml(config));
  }
  const Config first = parse_config(begin + "source_settings: {back: {range_max: 7}}}}", "f");
  EXPECT_EQ(first.merged_scans.at(0).source_settings.count("back"), 1U);
}

TEST(ConfigSources, FindsACloudByTheTopicThatItsSensorPublishes) {
  const std::string begin =
      "sensors: {roof: {model: velodyne_vlp16, points_topic: velodyne_points}}\n"
      "virtual_scans: {v: {virtual_laser_scan: a, cloud_topic: ";
  for (const char* name : {"roof", "velodyne_points", "/velodyne_points"})
    EXPECT_EQ(parse_config(begin + name + "}}", "f").virtual_scans.at(0).cloud_topic, "roof") << name;
}

TEST(MergedScanConfig, AsksWhichSourceMustSeeAFreeBeamWhereHeightsDiffer) {
  const std::string sensors =
      "sensors:\n"
      "  low: {model: sick_microscan3, pose: {xyz: [0, 1, 0.2]}}\n"
      "  high: {model: sick_lms5xx, ip_address: 10.0.0.2, pose: {xyz: [0, -1, 0.6]}}\n"
      "vehicle: {footprint: [[-1, -1], [1, -1], [0, 1]]}\n"
      "merged_scans: {m: {laserscan_topics: [low, high], profile: strict, range_max: 30";
  const Config open = parse_config(sensors + "}}", "f");
  ASSERT_EQ(remarks_on(open).size(), 1U);
  EXPECT_THAT(remarks_on(open)[0], HasSubstr("0.20 to 0.60 m high"));
  const Config answered = parse_config(sensors + ", free_requires: low}}", "f");
  EXPECT_TRUE(remarks_on(answered).empty());
  const MergedScanConfig& m = answered.merged_scans[0];
  EXPECT_EQ(m.free_requires, std::vector<std::string>{"low"});
  EXPECT_FALSE(m.source_settings.at("high").proves_free);
  const auto low = m.source_settings.find("low");
  EXPECT_TRUE(low == m.source_settings.end() || low->second.proves_free);
}

}  // namespace
}  // namespace lidard
