// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/virtualizer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test/core/virtual/cut_bench.h"
#include "test/core/virtual/small_lidar.h"
#include "test/support/allocations.h"

namespace lidard {
namespace {

using namespace test::cut;

TEST(Virtualizer, AFrameUpsideDownShowsTheSameMirrored) {
  sim::Yard yard;
  yard.ground = false;
  yard.objects = {wall(8, -30, 8, 30, 12, -12), box({-5, 2, 1}, {1, 1, 3}), wall(-9, -30, -9, 30, 12, -12)};
  Cut cut, turned;
  cut.settings.ground.model = turned.settings.ground.model = GroundModel::none;
  // Not quite upright, so that steep beams of the plane also meet what lies higher and lower.
  cut.frame = make_pose({0.3, 0.2, 1.4}, {0.1, 0.05, 0});
  turned.frame = cut.frame * make_pose({0, 0, 0}, {pi_d, 0, 0});
  cut.make(seen(yard, lidar16()), lidar16().pose);
  turned.make(seen(yard, lidar16()), lidar16().pose);
  std::size_t hits = 0;
  for (std::size_t beam = 0; beam < cut.grid.beams; ++beam) {
    const double angle = cut.grid.angle(beam);
    const double upright = cut.range(cut.safety, angle);
    if (std::isnan(upright) || std::abs(angle) > 70 * degree) continue;
    ++hits;
    EXPECT_NEAR(turned.range(turned.safety, -angle), upright, 0.02) << angle / degree;
  }
  EXPECT_GT(hits, 200U);
}

TEST(Virtualizer, InATiltedPlaneTheWayIsFreeWhereverTheRingsReach) {
  // A round room of 12 m; the plane leans by 0.15 rad and passes 0.4 m beneath a lidar whose rings reach
  // 25 degrees down and up. The plane's axes are seen from another place than the lidar's.
  sim::Yard yard;
  yard.ground = false;
  for (int side = 0; side < 24; ++side) {
    const double a = side * 15 * degree, b = a + 15 * degree;
    yard.objects.push_back(
        wall(12 * std::cos(a), 12 * std::sin(a), 12 * std::cos(b), 12 * std::sin(b), 9, -9));
  }
  sim::YardLidar lidar = lidar16();
  lidar.elevations = sim::even_rings(32, -25, 25);
  Cut cut;
  cut.settings.ground.model = GroundModel::none;
  cut.settings.how.noise = 0.02;
  cut.frame = make_pose({0.9, 0.1, lidar_height - 0.4}, {0.15, 0, 0.4});
  cut.make(seen(yard, lidar), lidar.pose);
  EXPECT_EQ(cut.count(cut.safety, BeamStatus::hit), cut.grid.beams);
  EXPECT_GE(cut.count(cut.strict, BeamStatus::hit), cut.grid.beams * 95 / 100);
}

TEST(Virtualizer, AFrameOnItsSideIsCutToo) {
  sim::Yard yard;
  yard.ground = false;
  yard.objects = {wall(8, -30, 8, 30, 12, -12)};
  Cut cut;
  cut.settings.ground.model = GroundModel::none;
  cut.frame = make_pose({0, 0.013, 2}, {pi_d / 2, 0, 0});  // its plane stands upright through the x axis
  cut.make(seen(yard, lidar16()), lidar16().pose);
  for (double angle = -12 * degree; angle <= 12 * degree; angle += degree)
    EXPECT_NEAR(cut.range(cut.safety, angle), 8 / std::cos(cut.grid.angle(cut.grid.nearest(angle))), 0.010)
        << angle / degree;
}

TEST(Virtualizer, OverBareGroundNothingIsMetAndNothingIsClaimedNearerThanTheLowestBeam) {
  Cut cut;
  cut.make(seen({}, lidar16()), lidar16().pose);
  EXPECT_EQ(cut.count(cut.strict, BeamStatus::hit), 0U);
  EXPECT_EQ(cut.count(cut.safety, BeamStatus::hit), 0U);
  // No beam sees the way's begin, so none is free.
  EXPECT_EQ(cut.count(cut.strict, BeamStatus::none), 0U);
  EXPECT_EQ(cut.count(cut.safety, BeamStatus::none), 0U);
  EXPECT_EQ(cut.covered_ahead, 0);
}

TEST(Virtualizer, TheWayIsFreeFromTheLowestBeamsCrossingOn) {
  const double blind = (lidar_height - plane_height) / std::tan(15 * degree);
  sim::Yard yard;
  yard.objects = {wall(20, -30, 20, 30)};
  Cut cut;
  cut.make(seen(yard, lidar16()), lidar16().pose);
  const std::size_t ahead = cut.grid.nearest(0);
  ASSERT_EQ(cut.strict.statuses[ahead], BeamStatus::hit);
  ASSERT_EQ(cut.strict.free_from.size(), cut.grid.beams);
  EXPECT_NEAR(static_cast<double>(cut.strict.free_from[ahead]), blind, 0.2);
}

TEST(Virtualizer, NoDirectionIsFreeNearerThanTheLowestBeamCrossesThePlane) {
  const double blind = (lidar_height - plane_height) / std::tan(15 * degree);
  sim::Yard yard;
  yard.objects = {wall(20, -20, 20, 20),       wall(20, 20, -20, 20),         wall(-20, 20, -20, -20),
                  wall(-20, -20, 20, -20),     box({9, 2, 1}, {0.3, 0.3, 2}), box({-7, 1, 1}, {2, 0.1, 2}),
                  box({1, -8, 1}, {0.1, 2, 2})};
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(0, 0), {0.8, -0.5}, {-2, 1}, {2.5, 2.5}}) {
    Cut cut;
    cut.frame = make_pose({at.x(), at.y(), plane_height}, {0, 0, 0.3});
    cut.make(seen(yard, lidar16()), lidar16().pose);
    std::size_t hits = 0;
    for (std::size_t beam = 0; beam < cut.grid.beams; ++beam) {
      if (cut.strict.statuses[beam] != BeamStatus::hit) continue;
      ++hits;
      // Where the beam leaves the circle that no ring reaches down to.
      const double angle = cut.grid.angle(beam) + 0.3;
      const double along = -at.dot(Eigen::Vector2d(std::cos(angle), std::sin(angle)));
      const double end = along + std::sqrt(along * along - at.squaredNorm() + blind * blind);
      EXPECT_NEAR(static_cast<double>(cut.strict.free_from[beam]), end, 0.25)
          << at.transpose() << ", " << beam;
    }
    EXPECT_GT(hits, 600U) << at.transpose();
  }
}

TEST(Virtualizer, FromTheLidarsOwnHeightAnOpenFieldIsFree) {
  sim::Yard yard;
  yard.objects = {wall(10, -5, 10, 5)};
  Cut cut;
  cut.frame = make_pose({0, 0, lidar_height}, {0, 0, 0});
  cut.grid = full_circle(720);
  cut.make(seen(yard, lidar16()), lidar16().pose);
  EXPECT_NEAR(cut.range(cut.strict, 0), 10, 0.01);
  for (const double angle : {90.0, 135.0, -170.0, -90.0})
    EXPECT_EQ(cut.strict.statuses[cut.grid.nearest(angle * degree)], BeamStatus::none) << angle;
}

TEST(Virtualizer, WithoutFaithInMissingReturnsNothingIsFree) {
  Cut cut;
  cut.frame = make_pose({0, 0, lidar_height}, {0, 0, 0});
  cut.settings.beams.no_return_free_range = 0;
  cut.make(seen({}, lidar16()), lidar16().pose);
  EXPECT_EQ(cut.count(cut.strict, BeamStatus::invalid), cut.grid.beams);
}

TEST(Virtualizer, ASlabOverheadIsInABandButNotInASliceBeneath) {
  sim::Yard yard;
  yard.objects = {box({8, 0, 2.3}, {1, 4, 0.3}), wall(20, -30, 20, 30)};
  const Cloud cloud = seen(yard, lidar16());
  Cut slice;
  slice.make(cloud, lidar16().pose);
  EXPECT_NEAR(slice.range(slice.strict, 0), 20, 0.01);
  Cut band;
  band.settings.mode = CutMode::band;
  band.frame = make_pose({0, 0, 0}, {0, 0, 0});
  band.band = {0.1, 2.5};
  band.make(cloud, lidar16().pose);
  EXPECT_NEAR(band.range(band.safety, 0), 7.5, 0.02);
  EXPECT_NEAR(band.range(band.safety, 40 * degree), 20 / std::cos(40 * degree), 0.02);
}

TEST(Virtualizer, TheGroundIsNoObstacleUnlessThereIsNone) {
  Cut cut;
  cut.frame = make_pose({0, 0, -0.02}, {0, 0, 0});
  cut.settings.mode = CutMode::band;
  cut.band = {0, 0.5};
  const Cloud cloud = seen({}, lidar16());
  cut.make(cloud, lidar16().pose);
  EXPECT_EQ(cut.count(cut.safety, BeamStatus::hit), 0U);
  cut.settings.ground.model = GroundModel::none;
  cut.make(cloud, lidar16().pose);
  EXPECT_EQ(cut.count(cut.safety, BeamStatus::hit), cut.grid.beams);
}

TEST(Virtualizer, ASlopingDriveIsGroundByItsSlope) {
  // A ramp of 8 % that a plane at z = 0 does not describe.
  sim::Yard yard;
  yard.ground = false;
  sim::Object ramp = box({0, 0, -0.5}, {80, 80, 1});
  ramp.pose = make_pose({0, 0, -0.5}, {0, -std::atan(0.08), 0});
  yard.objects = {ramp, wall(12, -30, 12, 30, 5)};
  const Cloud cloud = seen(yard, lidar16());
  Cut cut;
  cut.frame = make_pose({0, 0, plane_height}, {0, -std::atan(0.08), 0});
  cut.settings.ground = {GroundModel::slope, 0, 0.1, 0.15};
  cut.make(cloud, lidar16().pose);
  EXPECT_NEAR(cut.range(cut.strict, 0), 12, 0.1);
}

TEST(Virtualizer, AThinPoleIsNotLost) {
  sim::Yard yard;
  sim::Object pole;
  pole.shape = sim::Cylinder{0.03, 3};
  pole.pose = make_pose({6, 1, 1.5}, {0, 0, 0});
  yard.objects = {pole, wall(20, -40, 20, 40)};
  Cut cut;
  cut.make(seen(yard, lidar16()), lidar16().pose);
  const double angle = std::atan2(1.0, 6.0);
  double nearest = INFINITY;
  for (const double off : {-0.5, 0.0, 0.5}) {
    const double range = cut.range(cut.safety, angle + off * degree);
    if (range < nearest) nearest = range;
  }
  EXPECT_NEAR(nearest, std::hypot(6, 1) - 0.03, 0.05);
}

TEST(Virtualizer, LostPacketsLeaveASectorUnobserved) {
  sim::Yard yard;
  yard.objects = {wall(10, -30, 10, 30)};
  Cloud cloud = seen(yard, lidar16());
  // Azimuth counts clockwise: columns 50 to 89 look 10 to 18 degrees to the right.
  const auto lose = [](Cloud& from, std::size_t first, std::size_t count) {
    const std::uint32_t begin = from.columns[first].first_point;
    const std::uint32_t end = from.columns[first + count].first_point;
    auto& bytes = from.points_bytes;
    bytes.erase(bytes.begin() + begin * 22, bytes.begin() + end * 22);
    from.columns.erase(from.columns.begin() + static_cast<std::ptrdiff_t>(first),
                       from.columns.begin() + static_cast<std::ptrdiff_t>(first + count));
    for (std::size_t c = first; c < from.columns.size(); ++c) from.columns[c].first_point -= end - begin;
  };
  Cloud one_lost = cloud;
  lose(cloud, 50, 40);
  Cut cut;
  cut.make(cloud, lidar16().pose);
  for (double angle = 11; angle < 17.5; angle += 0.5) {
    EXPECT_EQ(cut.strict.statuses[cut.grid.nearest(-angle * degree)], BeamStatus::invalid) << angle;
    EXPECT_EQ(cut.safety.statuses[cut.grid.nearest(-angle * degree)], BeamStatus::invalid) << angle;
  }
  EXPECT_NEAR(cut.range(cut.strict, -9 * degree), 10 / std::cos(9 * degree), 0.01);
  EXPECT_NEAR(cut.range(cut.strict, -19 * degree), 10 / std::cos(19 * degree), 0.01);
  // A single column is bridged, two are not.
  cut.grid = full_circle(3600);
  lose(one_lost, 50, 1);
  cut.make(one_lost, lidar16().pose);
  EXPECT_NEAR(cut.range(cut.strict, -10 * degree), 10 / std::cos(10 * degree), 0.01);
  lose(one_lost, 50, 2);
  cut.make(one_lost, lidar16().pose);
  EXPECT_TRUE(std::isnan(cut.range(cut.strict, -10.2 * degree)));
}

TEST(Virtualizer, UnevenlySpacedColumnsLeaveNoHoles) {
  for (const double jitter : {0.0, 0.3, 0.5}) {
    test::rings::SmallLidar lidar(11);
    lidar.columns = 900, lidar.jitter = jitter;
    lidar.range = [&](std::size_t ring, std::size_t) { return 8 / std::cos(lidar.elevations[ring]); };
    Cut cut;
    cut.settings.ground.model = GroundModel::none;
    cut.frame = make_pose({0, 0, -0.3}, {0, 0, 0});
    cut.make(lidar.cloud(), Pose::Identity());
    EXPECT_EQ(cut.count(cut.strict, BeamStatus::hit), cut.grid.beams) << jitter;
  }
}

TEST(Virtualizer, TheVehicleItselfIsNeitherHitNorSeenThrough) {
  sim::Yard yard;
  yard.objects = {box({-1.5, 0, 1.7}, {0.6, 1.6, 0.6}), wall(-12, -30, -12, 30)};  // a cabin behind the lidar
  Cut cut;
  cut.footprint = Footprint({{-2, -1}, {0.5, -1}, {0.5, 1}, {-2, 1}});
  cut.frame = make_pose({0, 0, 1.6}, {0, 0, 0});
  cut.make(seen(yard, lidar16()), lidar16().pose);
  for (const PlanarScan* scan : {&cut.strict, &cut.safety}) {
    for (std::size_t beam = 0; beam < scan->beams; ++beam) {
      if (scan->statuses[beam] != BeamStatus::hit) continue;
      EXPECT_GT(scan->ranges[beam], 5) << cut.grid.angle(beam) / degree;
    }
    EXPECT_NE(scan->statuses[cut.grid.nearest(pi_d - 0.01)], BeamStatus::none);
  }
}

TEST(Virtualizer, AnEmptyCloudOrOneWithoutFinitePointsIsUnobserved) {
  Cut cut;
  Cloud cloud;
  cloud.stamp = Stamp{1};
  cut.make(cloud, lidar16().pose);
  EXPECT_EQ(cut.count(cut.safety, BeamStatus::invalid), cut.grid.beams);
  cloud = seen({}, lidar16());
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.points()[i].x = NAN;
  cut.make(cloud, lidar16().pose);
  EXPECT_EQ(cut.count(cut.safety, BeamStatus::hit), 0U);
}

TEST(Virtualizer, NothingIsAllocatedPerCloudAfterWarmUp) {
  const sim::YardScene scene = sim::make_yard_scene(sim::yard_cases()[0], 2);
  VirtualSettings settings = settings_with_ground();
  Virtualizer virtualizer(scene.grid, {}, 2, settings);
  virtualizer.set_footprint(Footprint({{-2, -1}, {1, -1}, {1, 1}, {-2, 1}}));
  PlanarScan scans[2];
  const std::vector<VirtualScan> outputs = {{Profile::strict, &scans[0]}, {Profile::safety, &scans[1]}};
  const Pose first = scene.virtual_pose.inverse() * scene.lidar.pose;
  const Pose second = make_pose({0, 0, -1}, {0, 0, 0}).inverse() * first;
  const auto once = [&] {
    virtualizer.set_cloud(scene.cloud, scene.lidar.pose);
    virtualizer.project(0, first, outputs);
    virtualizer.project(1, second, outputs);
  };
  for (int i = 0; i < 3; ++i) once();
  const std::uint64_t before = test::allocations();
  for (int i = 0; i < 5; ++i) once();
  EXPECT_EQ(test::allocations() - before, 0U);
}

}  // namespace
}  // namespace lidard
