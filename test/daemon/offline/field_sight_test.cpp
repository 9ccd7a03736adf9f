// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What the merged and virtual scans of a configuration can know of an empty field, and what is in their way.
#include "daemon/offline/field_sight.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <regex>

#include "drivers/registry/registry.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<FieldSight> sights(const std::string& text) {
  const Config config = parse_config(text, "f");
  const EmptyField field(config);
  return sights_of(config, field);
}

/// The only sight of a configuration.
FieldSight sight(const std::string& text) {
  const auto all = sights(text);
  EXPECT_EQ(all.size(), 1U);
  return all.at(0);
}

/// The configurations that the manual and the examples show, with their place.
std::vector<std::pair<std::string, std::string>> shown_configurations() {
  std::vector<std::pair<std::string, std::string>> all;
  std::vector<std::string> pages = {test::project_file("README.md")};
  for (const auto& entry : std::filesystem::directory_iterator(test::project_file("config/doc")))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  static const std::regex block("\n```yaml\n([^`]*)```");
  for (const std::string& page : pages) {
    const std::string text = test::content(page);
    for (std::sregex_iterator it(text.begin(), text.end(), block), end; it != end; ++it)
      all.emplace_back(page, (*it)[1]);
  }
  for (const auto& entry : std::filesystem::directory_iterator(test::project_file("config")))
    if (entry.path().extension() == ".yaml") all.emplace_back(entry.path(), test::content(entry.path()));
  return all;
}

/// Scanners on the front corners; `footprint` reaches `front` m ahead of them.
std::string two_scanners(const std::string& front, const std::string& keys = "") {
  return "vehicle: {footprint: [[-4, -1], [" + front + ", -1], [" + front +
         ", 1], [-4, 1]]}\n"
         "sensors:\n"
         "  left: {model: sick_microscan3, ip_address: 10.0.0.1, pose: {xyz: [0, 1, 0.35], rpy_deg: [0, 0, "
         "45]}}\n"
         "  right: {model: sick_microscan3, ip_address: 10.0.0.2, pose: {xyz: [0, -1, 0.35], rpy_deg: [0, 0, "
         "-45]}}\n"
         "merged_scans:\n"
         "  scan: {laserscan_topics: [left, right], profile: strict, range_max: 30" +
         keys + "}\n";
}

std::string one_scanner(const std::string& pose, const std::string& keys, const std::string& sensor = "") {
  return "sensors: {front: {model: sick_microscan3, ip_address: 10.0.0.1, pose: " + pose + sensor +
         "}}\n"
         "vehicle: {footprint: [[-1, -0.5], [0, -0.5], [0, 0.5], [-1, 0.5]]}\n"
         "merged_scans: {scan: {laserscan_topics: [front], profile: strict, destination_pose: {xyz: [0, 0, "
         "0.3]}, destination_frame: low, " +
         keys + "}}\n";
}

TEST(EmptyField, TheExamplesOfTheManualSeeWhatIsAhead) {
  std::size_t merged = 0;
  for (const auto& [place, text] : shown_configurations()) {
    const Config config = parse_config(text, place);
    const EmptyField field(config);
    for (const FieldSight& one : sights_of(config, field)) {
      const std::string what = place + ": " + comments_of({one}, field);
      if (!one.came || one.free.ahead < 0) continue;
      if (one.entry.find("merged_scans") == 0 && one.proves) {
        ++merged;
        EXPECT_GE(one.free.ahead, 95) << what;
      } else if (one.proves && one.free.ahead < 95) {
        // The blind zone of a lidar on the roof, which the pages explain.
        double blind = 0;
        for (const Hindrance& each : one.hindrances)
          if (each.limit == Limit::elevations) blind = each.beams.ahead;
        EXPECT_GE(one.free.ahead + blind, 90) << what;
      }
    }
  }
  EXPECT_GE(merged, 9U);
}

TEST(EmptyField, ScannersOnTheCornersOfTheOutlineSeeAllButWhatTheVehicleHides) {
  const FieldSight one = sight(two_scanners("0"));
  EXPECT_GE(one.free.ahead, 99);
  EXPECT_NEAR(one.free.all, 92.4, 1);
  ASSERT_EQ(one.hindrances.size(), 1U);
  EXPECT_NEAR(one.hindrances[0].beams.all, 100 - one.free.all, 0.01);
  EXPECT_THAT(one.hindrances[0].sentence, HasSubstr("the vehicle itself"));
}

TEST(EmptyField, AnOutlineAheadOfTheScannersIsNamedWithItsDistance) {
  const FieldSight one = sight(two_scanners("0.6"));
  EXPECT_LT(one.free.ahead, 50);
  ASSERT_FALSE(one.hindrances.empty());
  EXPECT_EQ(one.hindrances[0].limit, Limit::none);
  EXPECT_GE(one.hindrances[0].beams.ahead, 50);
  EXPECT_THAT(one.hindrances[0].sentence,
              AllOf(HasSubstr("ends 0.60 m beyond left, right"), HasSubstr("move its edge")));
}

TEST(EmptyField, TheBlindZoneOfALidarIsNamedWithItsReach) {
  const FieldSight one = sight(
      "sensors: {roof: {model: velodyne_vlp16, pose: {xyz: [0, 0, 2]}}}\n"
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: [bumper], profile: strict, poses: {bumper: "
      "{xyz: [0, 0, 0.3]}}, range_max: 40}}\n");
  EXPECT_EQ(one.free.all, 0);
  ASSERT_EQ(one.hindrances.size(), 1U);
  EXPECT_EQ(one.hindrances[0].limit, Limit::elevations);
  EXPECT_EQ(one.hindrances[0].beams.all, 100);
  // 1.7 m / tan(15 deg).
  EXPECT_THAT(one.hindrances[0].sentence,
              AllOf(HasSubstr("roof (nearer than 6.3 m)"), HasSubstr("merge it")));
}

TEST(EmptyField, AVirtualScanAtTheHeightOfItsLidarSeesAllRound) {
  const FieldSight one = sight(
      "sensors: {roof: {model: velodyne_vlp16, pose: {xyz: [0, 0, 2]}}}\n"
      "virtual_scans: {v: {cloud_topic: roof, virtual_laser_scan: [eye], profile: safety, poses: {eye: "
      "{xyz: [0, 0, 2]}}, range_max: 50}}\n");
  EXPECT_GE(one.free.all, 99);
}

TEST(EmptyField, AScannerAtAHeightThatDoesNotCountIsNamed) {
  const FieldSight one =
      sight(one_scanner("{xyz: [0, 0, 0.7]}", "min_height: -0.15, max_height: 0.15, range_max: 20"));
  EXPECT_EQ(one.free.all, 0);
  ASSERT_FALSE(one.hindrances.empty());
  EXPECT_EQ(one.hindrances[0].limit, Limit::heights);
  EXPECT_GE(one.hindrances[0].beams.ahead, 99);
  EXPECT_THAT(one.hindrances[0].sentence, HasSubstr("above low stand front 0.40 m"));
}

TEST(EmptyField, ATiltedScannerThatMeetsTheGroundIsNamed) {
  const FieldSight one = sight(one_scanner("{xyz: [0, 0, 0.3], rpy_deg: [0, 2, 0]}", "range_max: 20"));
  EXPECT_LT(one.free.ahead, 5) << "0.3 m / sin(2 deg) is 8.6 m";
  const auto tilt = std::find_if(one.hindrances.begin(), one.hindrances.end(),
                                 [](const Hindrance& each) { return each.limit == Limit::heights; });
  ASSERT_NE(tilt, one.hindrances.end());
  EXPECT_GE(tilt->beams.ahead, 95);
  EXPECT_THAT(tilt->sentence, HasSubstr("tilted by 2.0 degrees"));
}

TEST(EmptyField, AFieldOfViewThatEndsIsNamed) {
  const FieldSight one =
      sight(one_scanner("{xyz: [0, 0, 0.3]}", "range_max: 20", ", angle_min_deg: -20, angle_max_deg: 10"));
  EXPECT_NEAR(one.free.ahead, 50, 2);
  ASSERT_FALSE(one.hindrances.empty());
  EXPECT_EQ(one.hindrances[0].limit, Limit::angles);
  EXPECT_NEAR(one.hindrances[0].beams.ahead, 50, 2);
}

TEST(EmptyField, ARangeBeyondTheReachOfTheSourcesIsNamed) {
  const FieldSight one = sight(one_scanner("{xyz: [0, 0, 0.3]}", "range_max: 200"));
  EXPECT_EQ(one.free.all, 0);
  ASSERT_FALSE(one.hindrances.empty());
  EXPECT_EQ(one.hindrances[0].limit, Limit::reach);
  EXPECT_THAT(one.hindrances[0].sentence, HasSubstr("lower range_max"));
}

TEST(EmptyField, TheViewOfAnotherDriversSourceIsAssumedAndSaidSo) {
  const Config config = parse_config(
      "sensors: {front: {topic: /other, pose: {xyz: [1, 0, 0.3]}}}\n"
      "merged_scans: {scan: {laserscan_topics: [front], profile: strict, destination_frame: front, "
      "range_max: 20}}\n",
      "f");
  const EmptyField field(config);
  EXPECT_THAT(field.assumed(), ElementsAre("front"));
  const auto all = sights_of(config, field);
  EXPECT_GE(all.at(0).free.ahead, 99);
  EXPECT_NEAR(all.at(0).free.all, 75, 1) << "270 of 360 degrees";
  EXPECT_THAT(comments_of(all, field),
              HasSubstr("# front: its field of view is not known, assumed: that of a TiM7xx"));
}

TEST(EmptyField, AnOutputWhosePosesComeFromTfIsSaidToBeUnknown) {
  const FieldSight one = sight(
      "sensors: {front: {model: sick_tim7xx, ip_address: 10.0.0.1}}\n"
      "merged_scans: {scan: {laserscan_topics: [front], profile: strict, range_max: 20}}\n");
  EXPECT_FALSE(one.came);
  EXPECT_THAT(one.hindrances, IsEmpty());
}

TEST(EmptyField, OdometryPoliciesAndLostSourcesDoNotKeepAScanAway) {
  const FieldSight one = sight(
      "vehicle: {odometry_topic: /odom}\n"
      "sensors:\n"
      "  front: {model: hokuyo_ust_10lx, ip_address: 10.0.0.1, pose: {xyz: [0, 0, 0.3]}, time_offset: -0.2}\n"
      "  nowhere: {model: sick_tim7xx, ip_address: 10.0.0.2}\n"
      "merged_scans: {scan: {laserscan_topics: [front, nowhere], profile: strict, policy: trigger, trigger: "
      "front, on_missing_motion: drop, range_max: 3.5, lost_after: 5}}\n");
  EXPECT_TRUE(one.came);
  EXPECT_GE(one.free.ahead, 99);
}

TEST(EmptyField, EveryModelButOneKnowsItsFieldOfView) {
  for (const Model& model : models()) {
    const FieldOfView& field = model.field;
    if (model.name == "sick_nav2xx") continue;  // no public source names its angles
    EXPECT_GT(field.beams, 100U) << model.name;
    const double last_deg = field.first_deg + field.step_deg * static_cast<double>(field.beams - 1);
    EXPECT_GE(field.first_deg, -180.01) << model.name;
    EXPECT_LE(last_deg, 180.01) << model.name;
    EXPECT_GE(last_deg - field.first_deg, 69) << model.name;
    EXPECT_EQ(field.elevations_deg.size(), model.kind == FrameKind::cloud ? model.beams : 0) << model.name;
    EXPECT_TRUE(std::is_sorted(field.elevations_deg.begin(), field.elevations_deg.end())) << model.name;
  }
}

}  // namespace
}  // namespace lidard
