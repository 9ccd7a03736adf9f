// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/visibility.h"

#include <algorithm>

#include "test/core/merge/merged_scene.h"

namespace lidard::test {
namespace {

/// Two scanners beside the origin in an open field, which measure so far, m.
MergedScene open_field(double reach, double range_max) {
  MergedScene scene;
  scene.noise(0.001);
  scene.beams = 720;
  scene.range_max = range_max;
  scene.add_scanner({0, 1}, 45);
  scene.add_scanner({0, -1}, -45);
  for (sim::FlatScanner& scanner : scene.scanners) scanner.range_max = reach;
  return scene;
}
constexpr std::size_t ahead = 360;

TEST(Visibility, WithoutAnySourceEverythingIsUnknown) {
  Visibility visibility(full_circle(360), {}, 0);
  visibility.compute({});
  PlanarScan scan;
  for (const Profile profile : {Profile::strict, Profile::safety}) {
    visibility.encode(profile, scan, false);
    EXPECT_EQ(violation(scan), nullptr);
    EXPECT_EQ(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::invalid), 360);
  }
}

TEST(Visibility, WayOutOfReachOfEveryScannerIsNotFree) {
  MergedScene scene = open_field(24, 30);
  scene.look();
  for (const PlanarScan* scan : {&scene.strict, &scene.safety})
    EXPECT_EQ(std::count(scan->statuses.begin(), scan->statuses.end(), BeamStatus::none), 0);
  EXPECT_NEAR(scene.merger->visibility()->covered(ahead), 24, 0.5);
}

TEST(Visibility, FreeNeedsProofToRangeMaxUnlessLessIsAskedFor) {
  // Straight ahead the end of 24 m is a little farther than that from both scanners beside the origin.
  for (const auto& [free_required, expected] :
       {std::pair(0, BeamStatus::invalid), {24, BeamStatus::invalid}, {23, BeamStatus::none}}) {
    MergedScene scene = open_field(24, 24);
    scene.settings.how.free_required = free_required;
    scene.look();
    EXPECT_EQ(scene.strict.statuses[ahead], expected) << free_required;
  }
}

TEST(Visibility, ItIsKnownToAStepHowFarAWayIsFree) {
  // Steps are 0.12 m, or 2.5 % of the range; distances are known to 3 mm.
  double worst_near = 0, worst_far = 0;
  for (double reach = 1; reach < 12; reach *= 1.013) {
    MergedScene scene = open_field(reach, 24);
    for (sim::FlatScanner& scanner : scene.scanners) scanner.at = {0, 0};
    scene.look();
    const auto covered = static_cast<double>(scene.merger->visibility()->covered(ahead));
    EXPECT_LE(covered, reach + 0.001);
    double& worst = reach < 4.8 ? worst_near : worst_far;
    worst = std::max(worst, (reach - covered) / (reach < 4.8 ? 1 : reach));
  }
  EXPECT_LT(worst_near, 0.1235);
  EXPECT_LT(worst_far, 0.0258);
}

}  // namespace
}  // namespace lidard::test
