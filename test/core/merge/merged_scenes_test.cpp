// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Scenes of which it can be said by hand what a merged scan must say where. SlowRuleScenes compares random
// ones with the rule, beam by beam; MergeBench with the truth.
#include <functional>
#include <string>

#include "test/core/merge/merged_scene.h"

namespace lidard::test {
namespace {

constexpr BeamStatus hit = BeamStatus::hit, none = BeamStatus::none, unknown = BeamStatus::invalid;

struct Scene {
  const char* name;
  std::function<void(MergedScene&)> set_up;
  struct Sector {
    double from, to;  // deg
    BeamStatus status;
  };
  std::vector<Sector> sectors;
  bool is_mirrored = true;  // the same on the other side
};

/// The vehicle of the paper on ira_laser_tools: scanners on the front corners of a body of 4 x 2 m, the
/// output midway between them.
void paper(MergedScene& scene) {
  scene.outline = {{-4, -1}, {0, -1}, {0, 1}, {-4, 1}};
  scene.add_scanner({0, 1}, 45);
  scene.add_scanner({0, -1}, -45);
  for (sim::FlatScanner& scanner : scene.scanners) scanner.range_max = 60;
  scene.range_max = 50;
  scene.noise(0.001);
}
/// A room of 40 x 24 m, and a box 2 m ahead.
void paper_room(MergedScene& scene) {
  paper(scene);
  scene.world.add_box({0, 0}, {20, 12}, 0);
  scene.world.add_box({2.5, 0}, {0.5, 0.5}, 0);
}
/// The output's origin is that far before the scanners.
std::function<void(MergedScene&)> seen_from_before(double ahead) {
  return [ahead](MergedScene& scene) {
    paper(scene);
    scene.world.add_box({0, 0}, {12, 9}, 0);
    scene.origin = {ahead, 0};
  };
}
std::function<void(MergedScene&)> seen_from(const Eigen::Vector2d& origin) {
  return [origin](MergedScene& scene) {
    paper_room(scene);
    scene.outline.clear();
    scene.origin = origin;
  };
}

/// A truck with forks at the height of its scanners: one on each front corner, perhaps one sunk into the
/// heel, perhaps one on each tip.
std::function<void(MergedScene&)> forks(bool heel, bool tips, bool posts = false) {
  return [=](MergedScene& scene) {
    scene.beams = 720;
    scene.range_max = 20;
    scene.world.add_box({0, 0}, {12, 9}, 0);
    for (const double y : {0.12, -0.12})
      if (posts) scene.world.add_box({1.5, y}, {0.03, 0.03}, 0);
    scene.foreign = scene.world;
    for (const double y : {0.35, -0.35}) scene.world.add_box({1.6, y}, {0.59, 0.09}, 0);
    scene.add_scanner({1, 0.6}, 45);
    scene.add_scanner({1, -0.6}, -45);
    if (heel) scene.add_scanner({0.97, 0}, 0);
    for (const double y : {0.35, -0.35})
      if (tips) scene.add_scanner({2.2, y}, 0);
    scene.outline = {{-1, -0.6}, {1, -0.6},   {1, -0.45},  {2.2, -0.45}, {2.2, -0.25}, {1, -0.25},
                     {1, 0.25},  {2.2, 0.25}, {2.2, 0.45}, {1, 0.45},    {1, 0.6},     {-1, 0.6}};
  };
}

std::function<void(MergedScene&)> alone(double yaw_deg) {
  return [yaw_deg](MergedScene& scene) { scene.add_scanner({0, 0}, yaw_deg); };
}

const Scene scenes[] = {
    {"AnOpenFieldIsFreeButForTheBlindConeBehindTheVehicle", paper, {{0, 165.4, none}, {167.5, 180, unknown}}},
    {"NoBeamSeesThroughABoxNearTheVehicle", paper_room, {{0, 13.5, hit}, {167.5, 180, unknown}}},
    {"AThinPoleIsNotSeenThrough",  // 6 cm wide, 3.16 m away
     [](MergedScene& scene) {
       paper_room(scene);
       for (sim::FlatScanner& scanner : scene.scanners) scanner.increment = degree;
       scene.world.add_box({1, -3}, {0.03, 0.03}, 0);
     },
     {{-71.9, -71.2, hit}},
     false},
    {"OfAWallSeenFromBehindAloneNothingIsSaid",  // what it is the back of may be thick
     [](MergedScene& scene) {
       scene.add_scanner({6, 0}, 180);
       scene.world.add_wall({3, -2}, {3, 2});
     },
     {{0, 20, unknown}}},
    {"AnOriginInsideABoxMakesNoClaims", seen_from({2.5, 0}), {{0, 180, unknown}}},
    {"AnOriginOutsideOfTheRoomMakesNoClaims", seen_from({50, 30}), {{-180, 180, unknown}}, false},
    {"TheVehicleIsTransparent", seen_from_before(0), {{100, 155, hit}, {170, 180, unknown}}},
    {"TheVehicleIsTransparentToAnOriginJustOutside",
     seen_from_before(0.1),
     {{100, 155, hit}, {170, 180, unknown}}},
    {"TheVehicleIsTransparentToAnOriginOutside",
     seen_from_before(0.5),
     {{100, 155, hit}, {170, 180, unknown}}},
    // Through the space between the forks alone, and through it and a fork.
    {"TheSpaceBetweenForksIsSeenFromTheirHeel", forks(true, false), {{0, 4, hit}, {5.7, 7, hit}}},
    {"TheSpaceBetweenForksMustBeSeen", forks(false, false), {{0, 4, unknown}, {5.7, 7, unknown}}},
    {"FromTheTipsOfForksTheSpaceBetweenThemIsNotSeen",
     forks(false, true),
     {{0, 4, unknown}, {5.7, 7, unknown}}},
    {"FromHeelAndTipsAllIsSeen", forks(true, true), {{5.7, 7, hit}}},
    {"WhatStandsBetweenForksIsSeen", forks(true, false, true), {{4.4, 4.6, hit}}},
    {"AnOriginInAScannerLosesNoBeam", alone(0), {{0, 134, none}, {136, 180, unknown}}},
    {"AnOriginInAScannerThatLooksToTheLeftLosesNoBeam",
     alone(90),
     {{-44, 180, none}, {-134, -46, unknown}},
     false},
    {"AnOriginInAScannerThatLooksAskewLosesNoBeam",
     alone(-100),
     {{-179, 34, none}, {36, 124, unknown}, {126, 179, none}},
     false},
    {"AnOriginInAScannerThatLooksBackLosesNoBeam", alone(180), {{46, 180, none}, {0, 44, unknown}}}};

class MergedScenes : public ::testing::TestWithParam<Scene> {};

TEST_P(MergedScenes, SayWhereTheyAreKnownWhatIsThere) {
  MergedScene scene;
  GetParam().set_up(scene);
  scene.look();
  for (const Scene::Sector& sector : GetParam().sectors) {
    scene.expect(sector.from, sector.to, sector.status);
    if (GetParam().is_mirrored) scene.expect(-sector.to, -sector.from, sector.status);
  }
  // Across a corner the chord between two beams cuts a little off.
  scene.expect_hits_on_the_world(0.1);
}

INSTANTIATE_TEST_SUITE_P(ByHand, MergedScenes, ::testing::ValuesIn(scenes),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace lidard::test
