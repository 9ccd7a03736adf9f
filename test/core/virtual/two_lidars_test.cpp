// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Virtual scans of two lidars beside a mast, which hides a part of the yard from each of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/virtual/virtualizer.h"
#include "test/sim/world/circle.h"
#include "test/support/yard.h"

namespace lidard::test::two_lidars {
namespace {

const Pose mounts[] = {make_pose({0, 0.7, 2}, {0, 0, 0}), make_pose({0, -0.7, 2}, {0, 0, 0.3})};
constexpr double noise = 0.02;  // m

/// A yard with the truth of a virtual frame, and the clouds of both lidars on a vehicle with a mast.
struct Scene {
  Scene(const sim::YardCase& set_up, std::uint64_t seed, double range_max)
      : yard(sim::make_yard_scene(set_up, seed)) {
    sim::Yard with_mast = yard.yard;
    sim::Object mast;
    mast.shape = sim::Box{{0.3, 0.3, 3}};
    mast.pose = make_pose({0, 0, 1.5}, {0, 0, 0});
    with_mast.objects.push_back(mast);
    sim::Rng rng(seed);
    for (int i = 0; i < 2; ++i) {
      sim::YardLidar lidar = yard.lidar;
      lidar.noise = noise;
      lidar.pose = mounts[i];
      clouds[i] = sim::measure(with_mast, lidar, rng);
    }
    grid = full_circle(yard.grid.beams, range_max);
  }
  /// The scan of the lidars of which a cloud is given.
  PlanarScan scan(Profile profile, const Cloud* first, const Cloud* second,
                  CutMode mode = CutMode::slice) const {
    VirtualSettings settings;
    settings.visibility = true;
    settings.how.noise = noise;
    settings.mode = mode;
    settings.ground.model = GroundModel::plane;
    settings.beams.no_return_free_range = yard.lidar.range_max;
    Virtualizer virtualizer(grid, mode == CutMode::band ? HeightBand{-0.1, 0.1} : HeightBand{}, 1, settings,
                            2);
    virtualizer.set_footprint(Footprint({{-1, -1.2}, {1, -1.2}, {1, 1.2}, {-1, 1.2}}));
    virtualizer.set_clouds({{first, mounts[0]}, {second, mounts[1]}});
    const Pose poses[] = {yard.virtual_pose.inverse() * mounts[0], yard.virtual_pose.inverse() * mounts[1]};
    PlanarScan made;
    virtualizer.project(0, poses, {{profile, &made}});
    return made;
  }
  double truth(double angle) const {
    const Pose& pose = yard.virtual_pose;
    return yard.yard.cast(
        {pose.translation(), pose.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0)}, false);
  }
  /// What is right for a beam or half a beam to either side.
  bool is_right(const PlanarScan& scan, std::size_t beam) const {
    for (const double side : {0.0, -0.5, 0.5}) {
      const double real = truth(grid.angle(beam) + side * grid.increment);
      if (scan.statuses[beam] == BeamStatus::none && real > grid.range_max) return true;
      if (scan.statuses[beam] == BeamStatus::hit &&
          std::abs(real - static_cast<double>(scan.ranges[beam])) < 0.08)
        return true;
    }
    return false;
  }
  bool is_falsely_free(const PlanarScan& scan, std::size_t beam) const {
    if (scan.statuses[beam] != BeamStatus::none) return false;
    for (const double side : {0.0, -0.5, 0.5})
      if (truth(grid.angle(beam) + side * grid.increment) > grid.range_max - 0.08) return false;
    return true;
  }

  sim::YardScene yard;
  ScanGrid grid;
  Cloud clouds[2];
};

/// By who looks: the first lidar alone, the second one alone, and both.
struct Counts {
  std::size_t right[3] = {0, 0, 0}, through[3] = {0, 0, 0}, free[3] = {0, 0, 0};
  double blind[3] = {0, 0,
                     0};  // m in all, of beams that all show right: the begin of the way that no lidar sees
  std::size_t lost = 0;   // right of one of them alone, but not of both
  std::size_t newly_free = 0;  // falsely, and not so of one alone

  void add(const Scene& scene, Profile profile, CutMode mode = CutMode::slice) {
    const Cloud *a = &scene.clouds[0], *b = &scene.clouds[1];
    const PlanarScan scans[] = {scene.scan(profile, a, nullptr, mode), scene.scan(profile, nullptr, b, mode),
                                scene.scan(profile, a, b, mode)};
    for (std::size_t beam = 0; beam < scene.grid.beams; ++beam) {
      bool is_right[3], is_false[3];
      for (int i = 0; i < 3; ++i) {
        is_right[i] = scene.is_right(scans[i], beam);
        is_false[i] = scene.is_falsely_free(scans[i], beam);
        right[i] += is_right[i] ? 1 : 0;
        free[i] += scans[i].statuses[beam] == BeamStatus::none ? 1 : 0;
        through[i] += !is_right[i] && scans[i].statuses[beam] == BeamStatus::hit &&
                              static_cast<double>(scans[i].ranges[beam]) > scene.truth(scene.grid.angle(beam))
                          ? 1
                          : 0;
      }
      if (is_right[0] && is_right[1] && is_right[2]) {
        for (int i = 0; i < 3; ++i) blind[i] += static_cast<double>(scans[i].free_from[beam]);
      }
      lost += (is_right[0] || is_right[1]) && !is_right[2] ? 1 : 0;
      newly_free += is_false[2] && !is_false[0] && !is_false[1] ? 1 : 0;
    }
  }
};

TEST(TwoLidars, NothingIsFalselyFreeAndMoreIsRightThanOfEitherAlone) {
  for (const std::size_t which : {0U, 1U, 3U}) {
    for (const Profile profile : {Profile::strict, Profile::safety}) {
      Counts counts;
      for (std::uint64_t seed = 1; seed <= 10; ++seed)
        counts.add(Scene(sim::yard_cases()[which], seed, 60), profile);
      EXPECT_EQ(counts.free[2], 0U) << "the yard is closed";
      EXPECT_GT(counts.right[2], std::max(counts.right[0], counts.right[1]));
      EXPECT_LT(counts.lost, counts.right[2] / 100);
      EXPECT_LE(counts.through[2], counts.right[2] * 12 / 1000);
      // The plane at the lidars' height begins at their own places.
      if (which == 1) continue;
      EXPECT_LT(counts.blind[2], 0.95 * std::min(counts.blind[0], counts.blind[1]));
    }
  }
}

TEST(TwoLidars, WhatOneProvesFreeTheShadowOfTheMastDoesNotUndo) {
  for (const std::size_t which : {1U, 4U}) {
    for (const Profile profile : {Profile::strict, Profile::safety}) {
      Counts counts;
      for (std::uint64_t seed = 1; seed <= 10; ++seed)
        counts.add(Scene(sim::yard_cases()[which], seed, 12), profile);
      EXPECT_EQ(counts.newly_free, 0U);
      EXPECT_GT(counts.free[2], std::max(counts.free[0], counts.free[1]) * 105 / 100);
      EXPECT_LT(counts.lost, counts.right[2] / 100);
    }
  }
}

TEST(TwoLidars, OneWithoutACloudDoesNotSilenceTheOther) {
  const Scene scene(sim::yard_cases()[0], 1, 30);
  for (const Profile profile : {Profile::flatten, Profile::strict, Profile::safety}) {
    const auto hits = [&](const Cloud* first, const Cloud* second) {
      const PlanarScan scan = scene.scan(profile, first, second);
      return std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::hit);
    };
    EXPECT_GT(hits(nullptr, &scene.clouds[1]), 0);
    EXPECT_GT(hits(&scene.clouds[0], nullptr), 0);
    EXPECT_EQ(hits(nullptr, nullptr), 0);
  }
}

}  // namespace
}  // namespace lidard::test::two_lidars
