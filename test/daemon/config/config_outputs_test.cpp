// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "daemon/offline/remarks.h"
#include "drivers/registry/registry.h"
#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

using test::roof_and_rear;
using ::testing::ElementsAre;

Config with_outputs(const std::string& text) { return parse_config(roof_and_rear + text, "f"); }

TEST(MergedScanConfig, GetsItsDefaults) {
  const Config config = with_outputs("merged_scans: {m: {laserscan_topics: [rear]}}\n");
  const MergedScanConfig& merged = config.merged_scans.at(0);
  EXPECT_EQ(merged.name, "m");
  EXPECT_THAT(merged.laserscan_topics, ElementsAre("rear"));
  EXPECT_EQ(merged.destination_frame, "base_link");
  ASSERT_TRUE(merged.destination_pose);
  EXPECT_TRUE(merged.destination_pose->isApprox(Pose::Identity()));
  EXPECT_EQ(merged.scan_destination_topic, "m");
  EXPECT_EQ(merged.cloud_destination_topic, "");
  EXPECT_EQ(merged.schedule.lost_after, std::chrono::milliseconds(400));
  EXPECT_EQ(merged.output.profile, Profile::flatten);
  EXPECT_EQ(merged.output.empty, EmptyBeam::inf);
  EXPECT_FALSE(merged.output.min_height || merged.output.max_height);
  EXPECT_EQ(merged.output.grid.beams, 1440U);
  EXPECT_EQ(merged.output.grid.range_min, 0);
  EXPECT_EQ(merged.output.grid.range_max, 100);
}

TEST(MergedScanConfig, TakesTheParametersOfTheAncestor) {
  const Config config = with_outputs(
      "merged_scans:\n"
      "  m:\n"
      "    destination_frame: cart_frame\n"
      "    cloud_destination_topic: /merged_cloud\n"
      "    scan_destination_topic: /scan_multi\n"
      "    laserscan_topics: ' /rear '\n"
      "    angle_min: -2.36\n"
      "    angle_max: 2.36\n"
      "    angle_increment: 0.0058\n"
      "    time_increment: 0.0001\n"
      "    scan_time: 0.0333333\n"
      "    range_min: 0.45\n"
      "    range_max: 25.0\n");
  const MergedScanConfig& merged = config.merged_scans.at(0);
  EXPECT_EQ(merged.destination_frame, "cart_frame");
  EXPECT_FALSE(merged.destination_pose);
  EXPECT_EQ(merged.cloud_destination_topic, "/merged_cloud");
  EXPECT_EQ(merged.scan_destination_topic, "/scan_multi");
  EXPECT_THAT(merged.laserscan_topics, ElementsAre("rear"));
  const ScanGridSpec& grid = merged.output.grid;
  EXPECT_EQ(grid.angle_min, -2.36);
  EXPECT_EQ(grid.angle_max, 2.36);
  EXPECT_EQ(grid.angle_increment.value(), 0.0058);
  EXPECT_FALSE(grid.beams);
  EXPECT_EQ(grid.time_increment, 0.0001);
  EXPECT_EQ(grid.scan_time, 0.0333333);
  EXPECT_EQ(grid.range_min, 0.45);
  EXPECT_EQ(grid.range_max, 25.0);
}

TEST(MergedScanConfig, TakesOurOwnKeys) {
  const Config config = with_outputs(
      "merged_scans: {m: {laserscan_topics: rear, profile: flatten, empty: range_max_plus_one, min_height: "
      "-0.2, max_height: 1.5, lost_after: 0.1, beams: 720, destination_frame: x, destination_pose: {xyz: [1, "
      "0, 0]}}}\n");
  const MergedScanConfig& merged = config.merged_scans.at(0);
  EXPECT_EQ(merged.output.empty, EmptyBeam::range_max_plus_one);
  EXPECT_EQ(merged.output.min_height, -0.2);
  EXPECT_EQ(merged.output.max_height, 1.5);
  EXPECT_EQ(merged.schedule.lost_after, std::chrono::milliseconds(100));
  EXPECT_EQ(merged.output.grid.beams, 720U);
  ASSERT_TRUE(merged.destination_pose);
  EXPECT_EQ(merged.destination_pose->translation().x(), 1);
}

TEST(MergedScanConfig, TakesItsRangesFromTheModels) {
  const Config config =
      parse_config("sensors: {a: {model: sick_microscan3}}\nmerged_scans: {m: {laserscan_topics: a}}", "f");
  const ScanGridSpec& grid = config.merged_scans.at(0).output.grid;
  EXPECT_EQ(grid.range_min, find_model("sick_microscan3")->range_min);
  EXPECT_EQ(grid.range_max, find_model("sick_microscan3")->range_max);
}

TEST(MergedScanConfig, ReadsTheProfileAndWhatItNeeds) {
  const Config config = with_outputs(
      "merged_scans: {m: {laserscan_topics: rear, profile: strict, unobserved: minus_inf, empty: zero, "
      "echoes: all, veil_filter: no, range_noise: 0.03, range_max: 30, free_required: 28, also: {safe: "
      "safety, flat: flatten}}}\n"
      "vehicle: {footprint: [[-1, -1], [1, -1], [0, 1]]}");
  EXPECT_TRUE(remarks_on(config).empty());
  const MergedScanConfig& m = config.merged_scans[0];
  EXPECT_EQ(m.output.profile, Profile::strict);
  EXPECT_EQ(m.output.unobserved, EmptyBeam::minus_inf);
  EXPECT_EQ(m.output.empty, EmptyBeam::zero);
  EXPECT_EQ(m.source.echoes, EchoChoice::all);
  EXPECT_FALSE(m.source.veil_filter);
  EXPECT_EQ(m.source.noise, 0.03);
  EXPECT_EQ(m.free_required, 28);
  ASSERT_EQ(m.also.size(), 2U);
  EXPECT_EQ(m.also[0].topic, "safe");
  EXPECT_EQ(m.also[0].profile, Profile::safety);
  EXPECT_EQ(m.also[1].profile, Profile::flatten);
}

TEST(MergedScanConfig, IsReadAsPrintedAlsoWhereItEndsBelowTheLeastFreeRange) {
  const std::string printed =
      to_yaml(with_outputs("merged_scans: {m: {laserscan_topics: rear, range_max: 0.05}}"));
  EXPECT_THAT(printed, ::testing::HasSubstr("free_required: 0.05"));
  EXPECT_EQ(to_yaml(parse_config(printed, "again")), printed);
}

TEST(MergedScanConfig, WarnsWhenTheVehiclesOutlineIsNeededAndNotThere) {
  const Config config = with_outputs("merged_scans: {m: {laserscan_topics: rear, also: {safe: safety}}}");
  ASSERT_EQ(config.warnings.size(), 1U);
  EXPECT_THAT(config.warnings[0], ::testing::HasSubstr("vehicle.footprint is not set"));
}

TEST(MergedScanConfig, AnEndBelowTheBeginMeansASectorThroughStraightBehind) {
  for (const auto& [first, last, from, to] :
       {std::array{2.5, -2.5, 2.5, two_pi - 2.5}, std::array{6.0, 5.9, 6 - two_pi, 5.9},
        std::array{-6.0, -6.2, -6.0, two_pi - 6.2}, std::array{2.5, 3.78, 2.5, 3.78}}) {
    const Config config =
        with_outputs("merged_scans: {m: {laserscan_topics: rear, angle_min: " + std::to_string(first) +
                     ", angle_max: " + std::to_string(last) + "}}\n");
    EXPECT_NEAR(config.merged_scans[0].output.grid.angle_min, from, 1e-9);
    EXPECT_NEAR(config.merged_scans[0].output.grid.angle_max, to, 1e-9);
  }
}

TEST(MergedScanConfig, WarnsOfScansThatGmappingDrops) {
  const Config config = with_outputs("merged_scans:\n  m: {laserscan_topics: rear, beams: 2048}\n");
  EXPECT_THAT(config.warnings,
              ElementsAre("f:7:38: merged_scans.m has 2048 beams; gmapping needs fewer than 2048: set beams "
                          "lower where gmapping is to use the scan"));
  EXPECT_TRUE(with_outputs("merged_scans: {m: {laserscan_topics: rear, beams: 2047}}").warnings.empty());
}

TEST(VirtualScanConfig, GetsItsDefaults) {
  const Config config = with_outputs(
      "vehicle: {base_frame: base}\n"
      "merged_scans: {m: {laserscan_topics: rear}}\n"
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: /low high, poses: {low: {xyz: [0, 0, "
      "1]}}}}\n");
  const VirtualScanConfig& scan = config.virtual_scans.at(0);
  EXPECT_EQ(scan.cloud_topic, "roof");
  EXPECT_EQ(scan.base_frame, "base");
  EXPECT_THAT(scan.virtual_laser_scan, ElementsAre("low", "high"));
  EXPECT_EQ(scan.poses.size(), 1U);
  EXPECT_EQ(scan.poses.at("low").translation().z(), 1);
  EXPECT_EQ(scan.output_laser_topic, "");
  EXPECT_EQ(scan.output.min_height, -0.1);
  EXPECT_EQ(scan.output.max_height, 0.1);
  EXPECT_EQ(scan.output.grid.range_min, find_model("velodyne_vlp16")->range_min);
  EXPECT_EQ(scan.output.grid.range_max, find_model("velodyne_vlp16")->range_max);
  EXPECT_TRUE(remarks_on(config).empty());
}

TEST(VirtualScanConfig, ReadsTheProfileAndWhatItNeeds) {
  const Config config = with_outputs(
      "merged_scans: {m: {laserscan_topics: rear}}\n"
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: [low, high], profile: strict, mode: band, "
      "min_height: 0.1, max_height: 1.8, ground: {model: slope, z: -0.3, tolerance: 0.05}, "
      "echoes: all, range_max: 50, "
      "no_return_free_range: 40, unobserved: minus_inf, also: {safe: safety}}}\n");
  EXPECT_TRUE(remarks_on(config).empty());
  const VirtualScanConfig& scan = config.virtual_scans.at(0);
  EXPECT_EQ(scan.output.profile, Profile::strict);
  EXPECT_EQ(scan.mode, CutMode::band);
  EXPECT_EQ(scan.ground.model, GroundModel::slope);
  EXPECT_EQ(scan.ground.z, -0.3);
  EXPECT_TRUE(scan.early_returns);
  EXPECT_EQ(scan.no_return_free_range, 40);
  ASSERT_EQ(scan.also.size(), 1U);
  EXPECT_EQ(scan.topic("low"), "low");
  EXPECT_EQ(scan.topic("low", &scan.also[0]), "low/safe");
  // Returns too near to measure are no free beams, so the driver keeps them.
  EXPECT_TRUE(config.find_sensor("roof")->driver.keep_too_near);
}

TEST(VirtualScanConfig, BeamsWithoutReturnProveFreedomOnlyWhereTheDriverIsOurs) {
  const Config config = with_outputs(
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: a, profile: strict, ground: plane},\n"
      "  w: {cloud_topic: rear, virtual_laser_scan: b, profile: safety, ground: none}}\n");
  EXPECT_TRUE(remarks_on(config).empty());
  EXPECT_EQ(config.virtual_scans[0].no_return_free_range, find_model("velodyne_vlp16")->range_max);
  EXPECT_EQ(config.virtual_scans[0].ground.model, GroundModel::plane);
  EXPECT_EQ(config.virtual_scans[1].no_return_free_range, 0);
}

TEST(VirtualScanConfig, BeamsWithoutReturnProveNoMoreThanTheRangeOfDarkTargets) {
  const auto free_range = [](const std::string& model, const std::string& keys) {
    const Config config = parse_config("sensors: {roof: {model: " + model +
                                           "}}\nvirtual_scans: {v: {cloud_topic: "
                                           "roof, virtual_laser_scan: a, profile: strict" +
                                           keys + "}}\n",
                                       "f");
    return config.virtual_scans[0].no_return_free_range;
  };
  EXPECT_EQ(free_range("velodyne_hdl64e_s3", ""), 50) << "at a reflectivity of 10 %";
  EXPECT_EQ(free_range("velodyne_hdl64e_s3", ", no_return_free_range: 100"), 100);
  EXPECT_EQ(free_range("velodyne_vlp16", ""), find_model("velodyne_vlp16")->range_max) << "not known";
}

TEST(MergedScanConfig, BeamsWithoutReturnProveNoMoreThanTheRangeOfDarkTargets) {
  const auto settings = [](const std::string& keys) {
    return parse_config(
               "sensors: {a: {model: hokuyo_ust_10lx, ip_address: 10.0.0.1}, b: {model: "
               "hokuyo_utm_30lx_ew, ip_address: 10.0.0.2}, c: {topic: /scan}}\n"
               "merged_scans: {m: {laserscan_topics: [a, b, c], range_noise: 0.03, " +
                   keys + "}}\n",
               "f")
        .merged_scans[0]
        .source_settings;
  };
  EXPECT_EQ(settings("profile: flatten").size(), 0U) << "points alone prove nothing";
  const auto known = settings("profile: strict");
  ASSERT_EQ(known.size(), 1U);
  EXPECT_EQ(known.at("a").no_return_free_range, 4);
  EXPECT_EQ(known.at("a").noise, 0.03);
  EXPECT_EQ(settings("profile: strict, source_settings: {a: {range_max: 8}}").at("a").no_return_free_range,
            4);
  EXPECT_EQ(settings("also: {s: safety}, source_settings: {a: {no_return_free_range: 9}}")
                .at("a")
                .no_return_free_range,
            9)
      << "what is written counts";
}

TEST(VirtualScanConfig, LooksForTheGroundUnlessItIsToldWhereItIs) {
  const Config config = with_outputs(
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: a, profile: strict},\n"
      "  w: {cloud_topic: roof, virtual_laser_scan: b, profile: strict, ground: none}}\n"
      "merged_scans: {m: {laserscan_topics: rear}}\n");
  EXPECT_TRUE(remarks_on(config).empty());
  EXPECT_EQ(config.virtual_scans[0].ground.model, GroundModel::slope);
  EXPECT_EQ(config.virtual_scans[1].ground.model, GroundModel::none);
}

TEST(VirtualScanConfig, WarnsOfSeveralFramesOnOneTopic) {
  const Config config = with_outputs(
      "merged_scans: {m: {laserscan_topics: rear}}\n"
      "virtual_scans:\n"
      "  v: {cloud_topic: roof, virtual_laser_scan: [a, b], output_laser_topic: all}\n");
  EXPECT_EQ(config.virtual_scans.at(0).output_laser_topic, "all");
  EXPECT_THAT(
      config.warnings,
      ElementsAre("f:8:74: virtual_scans.v.output_laser_topic carries scans of 2 frames; leave it empty "
                  "for one topic per frame"));
}

}  // namespace
}  // namespace lidard
