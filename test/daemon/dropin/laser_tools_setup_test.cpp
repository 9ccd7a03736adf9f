// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "daemon/config/config.h"
#include "daemon/dropin/dropin.h"

namespace lidard {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string error_of(const std::function<DropinSetup()>& setup) {
  try {
    parse_config(setup().keys.yaml(), "p");
    return "no error";
  } catch (const ConfigError& error) {
    return error.what();
  }
}

Config merger_of(const NodeParameters& parameters) {
  return parse_config(laser_merger_setup(parameters).keys.yaml(), "p");
}

Config virtualizer_of(const NodeParameters& parameters) {
  return parse_config(laser_virtualizer_setup(parameters).keys.yaml(), "p");
}

TEST(LaserMerger, HasTheDefaultsOfTheNodeItStandsInFor) {
  const Config config = merger_of({{"laserscan_topics", "/scansx"}});
  ASSERT_EQ(config.merged_scans.size(), 1U);
  const MergedScanConfig& merged = config.merged_scans[0];
  EXPECT_EQ(merged.destination_frame, "cart_frame");
  EXPECT_EQ(merged.scan_destination_topic, "/scan_multi");
  EXPECT_EQ(merged.cloud_destination_topic, "/merged_cloud");
  EXPECT_EQ(merged.output.profile, Profile::flatten);
  EXPECT_EQ(merged.output.empty, EmptyBeam::range_max_plus_one);
  EXPECT_FALSE(merged.output.min_height) << "every height counts";
  const ScanGridSpec& grid = merged.output.grid;
  EXPECT_EQ(grid.angle_min, -2.36);
  EXPECT_EQ(grid.angle_max, 2.36);
  EXPECT_EQ(grid.angle_increment, 0.0058);
  EXPECT_EQ(grid.time_increment, 0);
  EXPECT_EQ(grid.scan_time, 0.0333333);
  EXPECT_EQ(grid.range_min, 0.45);
  EXPECT_EQ(grid.range_max, 25);
}

TEST(LaserMerger, HasTheNumberOfBeamsThatSlamToolboxExpects) {
  const auto beams = [&](const NodeParameters& more) {
    NodeParameters all{{"laserscan_topics", "a"}};
    all.insert(more.begin(), more.end());
    return make_grid(merger_of(all).merged_scans[0].output.grid)->beams;
  };
  // round(span / increment) + 1, for which ira_laser_tools publishes 814 and 690.
  EXPECT_EQ(beams({}), 815U);
  EXPECT_EQ(beams({{"angle_min", "-2.0"}, {"angle_max", "2.0"}}), 691U);
  EXPECT_EQ(beams({{"angle_min", "-3.1416"}, {"angle_max", "3.1416"}}), 1083U) << "a full turn";
}

TEST(LaserMerger, AcceptsTopicsOfAnyNameOnceEach) {
  const DropinSetup setup =
      laser_merger_setup({{"laserscan_topics", " /scansx  front/scan /s2 /scansx front_scan "}});
  const Config config = parse_config(setup.keys.yaml(), "p");
  std::vector<std::string> topics;
  for (const auto& sensor : config.sensors) topics.push_back(sensor.topic);
  EXPECT_THAT(topics, ElementsAre("/scansx", "front/scan", "/s2", "front_scan"));
  EXPECT_THAT(config.merged_scans[0].laserscan_topics,
              ElementsAre("scansx", "front_scan_2", "s2", "front_scan"));
}

TEST(LaserMerger, BringsNumbersIntoTheLimitsOfDynamicReconfigureAndSaysSo) {
  const DropinSetup setup = laser_merger_setup(
      {{"laserscan_topics", "a"}, {"angle_min", "-3.1416"}, {"range_max", "2000"}, {"range_min", "0.3"}});
  const ScanGridSpec grid = parse_config(setup.keys.yaml(), "p").merged_scans[0].output.grid;
  EXPECT_DOUBLE_EQ(grid.angle_min, -3.14159265358979323846);
  EXPECT_EQ(grid.range_max, 1000);
  EXPECT_EQ(grid.range_min, 0.3);
  ASSERT_EQ(setup.warnings.size(), 2U);
  EXPECT_EQ(setup.warnings[1], "parameter ~range_max is 2000; the limit is 1000");
}

TEST(LaserMerger, KnowsKeysOfOurOwnConfiguration) {
  const DropinSetup setup = laser_merger_setup({{"laserscan_topics", "a b"},
                                                {"profile", "safety"},
                                                {"empty", "inf"},
                                                {"unobserved", "minus_inf"},
                                                {"lost_after", "0.2"},
                                                {"echoes", "first"},
                                                {"min_height", "0.05"}});
  EXPECT_THAT(setup.warnings, IsEmpty());
  const MergedScanConfig merged = parse_config(setup.keys.yaml(), "p").merged_scans[0];
  EXPECT_EQ(merged.output.profile, Profile::safety);
  EXPECT_EQ(merged.output.empty, EmptyBeam::inf);
  EXPECT_EQ(merged.output.unobserved, EmptyBeam::minus_inf);
  EXPECT_EQ(merged.schedule.lost_after, std::chrono::milliseconds(200));
  EXPECT_EQ(merged.source.echoes, EchoChoice::first);
  EXPECT_EQ(merged.output.min_height, 0.05);
}

TEST(LaserMerger, RefusesWhatTheOldNodeDiedOfOrIgnored) {
  const auto error = [](NodeParameters more) {
    more.insert({"laserscan_topics", "a"});
    return error_of([more] { return laser_merger_setup(more); });
  };
  EXPECT_EQ(error_of([] { return laser_merger_setup({}); }),
            "parameter ~laserscan_topics is empty; expected topics of LaserScans separated by blanks");
  EXPECT_EQ(error({{"angle_increment", "0"}}),
            "private parameters: angle_increment is not positive; expected a value above 0");
  EXPECT_THAT(error({{"angle_max", "-2.5"}}), HasSubstr("expected angle_min < angle_max"));
  EXPECT_THAT(error({{"range_max", "0.1"}}), HasSubstr("expected range_min < range_max"));
  EXPECT_EQ(error({{"range_max", "far"}}), "parameter ~range_max is 'far'; expected a number");
  EXPECT_THAT(error({{"scan_destination_topic", "scan multi"}}), HasSubstr("scan_destination_topic is"));
  EXPECT_THAT(error({{"profile", "strickt"}}), HasSubstr("expected strict, safety or flatten"));
}

TEST(LaserMerger, NamesUnknownParameters) {
  EXPECT_THAT(laser_merger_setup({{"laserscan_topics", "a"}, {"range_maxi", "5"}}).warnings,
              ElementsAre("parameter ~range_maxi is not known and has no effect; did you mean ~range_max?"));
  for (const char* name : {"beams", "destination_pose"}) {
    EXPECT_THAT(laser_merger_setup({{"laserscan_topics", "a"}, {name, "5"}}).warnings,
                ElementsAre(HasSubstr(std::string(name) + " is not known and has no effect")));
  }
}

TEST(LaserVirtualizer, HasTheDefaultsOfTheNodeItStandsInFor) {
  const Config config = virtualizer_of({{"virtual_laser_scan", "scansx scandx"}});
  ASSERT_EQ(config.virtual_scans.size(), 1U);
  const VirtualScanConfig& group = config.virtual_scans[0];
  EXPECT_EQ(config.sensors.at(0).topic, "/cloud_pcd");
  EXPECT_EQ(group.base_frame, "cart_frame");
  EXPECT_THAT(group.virtual_laser_scan, ElementsAre("scansx", "scandx"));
  EXPECT_EQ(group.output_laser_topic, "");
  EXPECT_EQ(group.output.grid.range_max, 25);
  EXPECT_EQ(group.output.empty, EmptyBeam::range_max_plus_one);
  EXPECT_EQ(group.output.min_height, -0.1) << "not the ground too, as in 1.0.7";
}

TEST(LaserVirtualizer, AppliesEveryParameter) {
  const DropinSetup setup = laser_virtualizer_setup({{"cloud_topic", "cloud_in"},
                                                     {"base_frame", "/laser_frame"},
                                                     {"output_laser_topic", "/scan"},
                                                     {"virtual_laser_scan", "bumper"},
                                                     {"angle_max", "1.5"},
                                                     {"max_height", "0.4"},
                                                     {"range_max", "80"}});
  EXPECT_THAT(setup.warnings, IsEmpty());
  const Config config = parse_config(setup.keys.yaml(), "p");
  const VirtualScanConfig& group = config.virtual_scans.at(0);
  EXPECT_EQ(config.sensors.at(0).topic, "cloud_in");
  EXPECT_EQ(group.base_frame, "laser_frame");
  EXPECT_EQ(group.output_laser_topic, "/scan");
  EXPECT_EQ(group.output.grid.angle_max, 1.5);
  EXPECT_EQ(group.output.grid.range_max, 80) << "the old node ends at 50 m";
  EXPECT_EQ(group.output.max_height, 0.4);
}

TEST(LaserVirtualizer, RefusesAnEmptyListOfFrames) {
  EXPECT_EQ(error_of([] {
              return laser_virtualizer_setup({{"virtual_laser_scan", " "}});
            }),
            "parameter ~virtual_laser_scan is empty; expected frames separated by blanks");
}

TEST(LaserVirtualizer, PrefersPrivateParametersToTheAbsoluteOnesOfTheOldNode) {
  const NodeParameters all =
      with_absolute_names({{"cloud_topic", "mine"}, {"angle_max", "1"}},
                          {{"cloud_topic", "theirs"}, {"virtual_laser_scan", "chest"}, {"angle_min", "-1"}});
  EXPECT_EQ(all.at("cloud_topic"), "mine");
  EXPECT_EQ(all.at("virtual_laser_scan"), "chest");
  EXPECT_EQ(all.count("angle_min"), 0U) << "which the old node reads from its private names";
}

}  // namespace
}  // namespace lidard
