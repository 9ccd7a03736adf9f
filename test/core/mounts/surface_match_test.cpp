// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/surface_match.h"

#include <gtest/gtest.h>

#include "core/base/angle.h"
#include "core/mounts/wall_fit.h"

namespace lidard {
namespace {

using Eigen::Vector2d;

/// The straight surface from one point to another, as a sensor with this pose sees it.
void add_wall(const Vector2d& from, const Vector2d& to, const PlanarPose& pose,
              std::vector<Surface>& surfaces) {
  StillView view;
  view.step = rad_per_deg;
  for (int i = 0; i <= 60; ++i) {
    const Vector2d point = pose.inverse() * Vector2d(from + (to - from) * i / 60);
    view.beams.push_back({point, point.norm(), 0, 0.005});
  }
  find_surfaces(view, surfaces);
}

TEST(MatchSurfaces, AFaceBesideTheEndsOfAnotherOneIsNotTakenForIt) {
  const PlanarPose at{0.1, -0.05, 2 * rad_per_deg};
  for (const double beside : {-3.0, 3.0}) {
    std::vector<Surface> a, b;
    add_wall({4, -1.5}, {4, 1.5}, {}, a), add_wall({4, -1.5}, {4, 1.5}, at, b);
    add_wall({-2, 5}, {2, 5}, {}, a), add_wall({-2, 5}, {2, 5}, at, b);
    add_wall({4.02, beside - 0.75}, {4.02, beside + 0.75}, at, b);
    ASSERT_EQ(b.size(), 3U);
    const PlanarPose found = match_surfaces(a, b, {}, 0.5);
    EXPECT_NEAR(found.x, at.x, 0.001) << beside;
    EXPECT_NEAR(found.y, at.y, 0.001) << beside;
    EXPECT_NEAR(found.yaw, at.yaw, 0.02 * rad_per_deg) << beside;
  }
}

TEST(WallFit, FacesOfOneLineWithAGapAreWallsOfTheirOwn) {
  Surroundings seen[2];
  for (Surroundings& one : seen) {
    one.views.resize(1);
    add_wall({4, -3}, {4, -1}, {}, one.surfaces), add_wall({4, 1}, {4, 3}, {}, one.surfaces);
  }
  std::vector<WallFit::Sensor> sensors(2);
  sensors[0].seen = &seen[0], sensors[1].seen = &seen[1];
  WallFit fit(sensors);
  EXPECT_TRUE(fit.find_walls(0.3));
  for (const WallFit::Sensor& sensor : fit.sensors()) EXPECT_EQ(sensor.shared, 2U);
  seen[1].surfaces.erase(seen[1].surfaces.begin());
  WallFit half(sensors);
  EXPECT_TRUE(half.find_walls(0.3));
  for (const WallFit::Sensor& sensor : half.sensors()) EXPECT_EQ(sensor.shared, 1U);
}

}  // namespace
}  // namespace lidard
