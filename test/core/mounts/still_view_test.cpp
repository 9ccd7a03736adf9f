// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/still_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/angle.h"
#include "core/mounts/surfaces.h"
#include "test/sim/world/rng.h"

namespace lidard {
namespace {

PlanarScan scan_of(std::size_t beams) {
  PlanarScan scan;
  scan.reset(beams);
  scan.set_angles(-0.5F, 0.01F);
  return scan;
}

TEST(StillView, WhatMovesThroughTheViewLeavesNoTrace) {
  StillScans scans;
  for (std::size_t frame = 0; frame < 20; ++frame) {
    PlanarScan scan = scan_of(100);
    for (std::size_t i = 0; i < scan.beams; ++i) scan.set_hit(i, i / 5 == frame ? 2.0F : 5.0F);
    ASSERT_TRUE(scans.add(scan));
  }
  const auto views = scans.views(Eigen::Matrix3d::Identity());
  for (const StillBeam& beam : views[0].beams) EXPECT_NEAR(beam.range, 5, 1e-6);
}

TEST(StillView, ABeamThatSeesNothingMostOfTheTimeIsFreeAndOneThatFlickersIsNotKnown) {
  StillScans scans;
  for (std::size_t frame = 0; frame < 20; ++frame) {
    PlanarScan scan = scan_of(3);
    frame < 3 ? scan.set_hit(0, 5) : scan.set_without_hit(0, BeamStatus::none);
    frame % 2 == 0 ? scan.set_hit(1, 5) : scan.set_without_hit(1, BeamStatus::none);
    scan.set_hit(2, 5);
    scans.add(scan);
  }
  const auto beams = scans.views(Eigen::Matrix3d::Identity())[0].beams;
  EXPECT_TRUE(std::isinf(beams[0].range));
  EXPECT_TRUE(std::isnan(beams[1].range));
  EXPECT_TRUE(beams[2].is_hit());
}

TEST(StillView, ABeamIsTheMeanOfItsReturnsAndKnowsItsError) {
  StillScans scans;
  sim::Rng rng(4);
  for (int frame = 0; frame < 50; ++frame) {
    PlanarScan scan = scan_of(200);
    for (std::size_t i = 0; i < scan.beams; ++i)
      scan.set_hit(i, static_cast<float>(5 + 0.02 * rng.gaussian()));
    scans.add(scan);
  }
  double square = 0;
  const auto views = scans.views(Eigen::Matrix3d::Identity());
  for (const StillBeam& beam : views[0].beams) {
    EXPECT_NEAR(beam.sigma, 0.02 / std::sqrt(50), 0.0015);
    square += std::pow((beam.range - 5) / beam.sigma, 2) / 200;
  }
  EXPECT_NEAR(square, 1, 0.4);
}

TEST(StillView, ScansOfAnotherGridAreNotAdded) {
  StillScans scans;
  EXPECT_TRUE(scans.add(scan_of(100)));
  EXPECT_FALSE(scans.add(scan_of(101)));
  PlanarScan turned = scan_of(100);
  turned.set_angles(-0.4F, 0.01F);
  EXPECT_FALSE(scans.add(turned));
  EXPECT_EQ(scans.frames(), 1U);
}

TEST(StillView, AScanWithoutBeamsDoesNotSetTheGrid) {
  StillScans scans;
  EXPECT_FALSE(scans.add(scan_of(0)));
  EXPECT_TRUE(scans.add(scan_of(100)));
}

TEST(StillView, BeamsOfARingAreNeighboursThoughBinsBetweenThemAreEmpty) {
  for (const double step_deg : {0.27, 1.0}) {
    StillScans scans;
    Cloud cloud;
    const auto count = static_cast<std::size_t>(90 / step_deg);
    cloud.points_bytes.resize(count * sizeof(CloudPoint));
    for (std::size_t i = 0; i < count; ++i) {
      const double azimuth = (step_deg * static_cast<double>(i) - 45) * rad_per_deg;
      cloud.points()[i] = {4, static_cast<float>(4 * std::tan(azimuth)), 0.5F, 0, 0, 0};
    }
    scans.add(cloud);
    const auto views = scans.views(Eigen::Matrix3d::Identity());
    std::vector<Surface> surfaces;
    find_surfaces(views[0], surfaces);
    ASSERT_EQ(surfaces.size(), 1U) << step_deg;
    EXPECT_GT(surfaces[0].length(), 7.5) << step_deg;
    EXPECT_NEAR(surfaces[0].height, 0.5, 1e-4) << step_deg;
  }
}

TEST(StillView, ACloudWhoseRingsNoLidarHasTakesNoMemory) {
  StillScans scans;
  Cloud cloud;
  cloud.points_bytes.resize(2 * sizeof(CloudPoint));
  cloud.points()[0] = {1, 0, 0, 0, 3, 0};
  cloud.points()[1] = {1, 0, 0, 0, 65535, 0};
  scans.add(cloud);
  EXPECT_EQ(scans.views(Eigen::Matrix3d::Identity()).size(), 4U);
}

/// A wall 4 m ahead that ends in a corner; behind the corner a wall goes away.
TEST(Surfaces, AreCutAtCornersAndKnowTheirErrors) {
  StillScans scans;
  PlanarScan scan = scan_of(100);
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const double angle = static_cast<double>(scan.angle(i));
    const double ahead = 4 / std::cos(angle), beside = angle > 0 ? 1.0 / std::sin(angle) : 1e9;
    scan.set_hit(i, static_cast<float>(std::min(ahead, beside)));
  }
  for (int frame = 0; frame < 10; ++frame) scans.add(scan);
  std::vector<Surface> surfaces;
  find_surfaces(scans.views(Eigen::Matrix3d::Identity())[0], surfaces);
  ASSERT_EQ(surfaces.size(), 2U);
  EXPECT_NEAR(surfaces[0].middle.x(), 4, 0.001);
  EXPECT_NEAR(surfaces[0].normal.x(), -1, 1e-4);
  EXPECT_NEAR(surfaces[1].middle.y(), 1, 0.001);
  EXPECT_NEAR(surfaces[1].normal.y(), -1, 1e-4);
  // An offset of the ranges moves the wall ahead away from the sensor by nearly as much.
  EXPECT_LT(surfaces[0].offset_by_range, -0.9);
  EXPECT_LT(surfaces[0].var_offset, 1e-6);
}

/// A laser's view of a straight face `ahead` m away that leans away by `lean` m per m of height.
StillView face(std::size_t ring, double height, double ahead, double lean, double turn_deg = 0) {
  StillView view;
  view.ring = ring, view.step = rad_per_deg;
  const Eigen::Rotation2Dd turn(turn_deg * rad_per_deg);
  for (int degree = -20; degree <= 20; ++degree) {
    const double x = ahead + lean * height;
    const Eigen::Vector2d point = turn * Eigen::Vector2d(x, x * std::tan(degree * rad_per_deg));
    view.beams.push_back({point, point.norm(), height, 0.005});
  }
  return view;
}

TEST(Surfaces, AreUprightWhereAnotherLaserSeesThemHigherOrLower) {
  EXPECT_EQ(find_upright({face(0, 0, 4, 0), face(1, 0.3, 4, 0)}).size(), 2U);
  EXPECT_EQ(find_upright({face(0, 0, 4, 0), face(1, 0.05, 4, 0)}).size(), 0U) << "both see one height";
  EXPECT_EQ(find_upright({face(0, 0, 4, 0.5), face(1, 0.3, 4, 0.5)}).size(), 0U) << "a slope";
  EXPECT_EQ(find_upright({face(0, 0, 4, 0), face(1, 0.3, 4, 0, 3)}).size(), 0U) << "turned";
  EXPECT_EQ(find_upright({face(0, 0, 4, 0), face(1, 0.3, 4.1, 0)}).size(), 0U) << "another face behind it";
  EXPECT_EQ(find_upright({face(0, 0, 4, 0), {}, {}, face(3, 0.3, 4, 0)}).size(), 2U);
  EXPECT_EQ(find_upright({face(0, 0, 4, 0), {}, {}, {}, face(4, 0.3, 4, 0)}).size(), 0U)
      << "too many rings apart";
}

}  // namespace
}  // namespace lidard
