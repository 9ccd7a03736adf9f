// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Profile `flatten` point by point, against a search of all points.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/virtual/virtualizer.h"
#include "test/core/virtual/small_lidar.h"
#include "test/sim/world/circle.h"

namespace lidard {
namespace {

using namespace test::rings;

Eigen::Vector3d place_of(const CloudPoint& p) { return Eigen::Vector3f(p.x, p.y, p.z).cast<double>(); }

/// Nearest range and its intensity per beam; no range: nothing.
struct Nearest {
  double range = 1e9, intensity = 0;
};

/// What a search of all points finds; `place` takes point i of the cloud to the virtual frame.
template <class Place>
std::vector<Nearest> search(const Cloud& cloud, const Pose& mount, const Footprint& body, HeightBand band,
                            Place place) {
  const ScanGrid grid = test::full_circle(360, 12, 1);
  std::vector<Nearest> found(grid.beams);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint& p = cloud.points()[i];
    const Eigen::Vector3d at = place(i);
    const double range = at.head<2>().norm();
    if (at.z() < band.min || at.z() > band.max || range < 1 || range > 12) continue;
    if (body.contains((mount * place_of(p)).head<2>())) continue;
    Nearest& beam = found[grid.nearest(std::atan2(at.y(), at.x()))];
    if (range < beam.range) beam = {range, static_cast<double>(p.intensity)};
  }
  return found;
}

void expect_same(const PlanarScan& scan, const std::vector<Nearest>& found) {
  ASSERT_EQ(scan.beams, found.size());
  std::size_t hits = 0, nothing = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i].range > 100) {
      ASSERT_EQ(scan.statuses[i], BeamStatus::none) << i;
      ++nothing;
      continue;
    }
    ASSERT_EQ(scan.statuses[i], BeamStatus::hit) << i;
    ASSERT_NEAR(static_cast<double>(scan.ranges[i]), found[i].range, 1e-4) << i;
    ASSERT_EQ(static_cast<double>(scan.intensities[i]), found[i].intensity) << i;
    ++hits;
  }
  EXPECT_GT(hits, 100U);
  EXPECT_GT(nothing, 5U);
}

/// A vehicle that drives an arc, and the motion of a cloud that was measured on it.
CloudMotion drive(const Cloud& cloud, const Pose& mount, PoseTrack& track) {
  for (int i = 0; i <= 60; ++i) {
    const double t = 0.002 * i;
    track.add(cloud.stamp + span_from_seconds(t - 0.001), make_pose({8 * t, 0.5 * t, 0}, {0, 0, 1.5 * t}));
  }
  CloudMotion motion;
  EXPECT_TRUE(motion.find(cloud, mount, track));
  EXPECT_FALSE(motion.stands());
  return motion;
}

TEST(VirtualizerPoints, FlattenIsTheNearestPointPerBeamAlsoWhileTheVehicleDrives) {
  const Footprint body({{-2, -1}, {1, -1}, {1, 1}, {-2, 1}});
  const HeightBand band{-0.4, 0.6};
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SmallLidar lidar(seed);
    lidar.range = [&](std::size_t, std::size_t) {
      return lidar.rng.uniform() < 0.5 ? 0.0 : 0.8 + 14 * lidar.rng.uniform();
    };
    Cloud cloud = lidar.cloud();
    const Pose mount = make_pose({0.3, -0.2, 1.5}, {0.05, -0.1, 6 * lidar.rng.uniform()});
    const Pose virtual_from_cloud = make_pose({-0.5, 0.3, 0.4}, {-0.05, 0.08, 1 + lidar.rng.uniform()});
    PoseTrack track;
    const CloudMotion motion = drive(cloud, mount, track);
    const bool moves = seed % 4 != 0, in_columns = seed % 3 != 0;
    std::vector<Eigen::Vector3d> places;
    for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
      const std::size_t end = c + 1 < cloud.columns.size() ? cloud.columns[c + 1].first_point : cloud.size();
      for (std::size_t i = cloud.columns[c].first_point; i < end; ++i) {
        const CloudPoint& p = cloud.points()[i];
        const Pose move = !moves ? Pose::Identity() : motion.at(static_cast<double>(p.time));
        places.push_back(virtual_from_cloud * (move * place_of(p)));
      }
    }
    if (!in_columns) cloud.columns.clear();
    Virtualizer virtualizer(test::full_circle(360, 12, 1), band);
    virtualizer.set_footprint(body);
    virtualizer.set_cloud(cloud, mount, moves ? &motion : nullptr);
    PlanarScan scan;
    virtualizer.project(0, virtual_from_cloud, {{Profile::flatten, &scan}});
    EXPECT_EQ(violation(scan), nullptr);
    SCOPED_TRACE(seed);
    expect_same(scan, search(cloud, mount, body.padded(Footprint::margin_m), band,
                             [&](std::size_t i) { return places[i]; }));
    EXPECT_EQ(scan.stamp, cloud.stamp);
    EXPECT_NEAR(static_cast<double>(scan.scan_time), seconds(cloud.end - cloud.stamp), 1e-6);
  }
}

TEST(VirtualizerPoints, ACloudWithoutRingsIsPointsInTheSafetyScanAlsoWhileTheVehicleDrives) {
  for (const bool moves : {false, true}) {
    SmallLidar lidar(3);
    lidar.range = [&](std::size_t, std::size_t) {
      return lidar.rng.uniform() < 0.5 ? 0.0 : 2 + 9 * lidar.rng.uniform();
    };
    Cloud cloud = lidar.cloud();
    cloud.columns.clear();
    cloud.rings = 1;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      cloud.points()[i].ring = 0;
      cloud.points()[i].z = static_cast<float>(4 * lidar.rng.uniform() - 2);
    }
    const Pose mount = make_pose({0.3, -0.2, 1.5}, {0, 0, 1});
    const Pose virtual_from_cloud = make_pose({-0.5, 0.3, 0.4}, {0, 0, 1.3});
    const HeightBand band{-0.4, 0.6};
    PoseTrack track;
    const CloudMotion motion = drive(cloud, mount, track);
    VirtualSettings settings;
    settings.visibility = true;
    settings.mode = CutMode::band;
    Virtualizer virtualizer(test::full_circle(360, 12, 1), band, 1, settings);
    virtualizer.set_cloud(cloud, mount, moves ? &motion : nullptr);
    EXPECT_STREQ(virtualizer.why_no_surfaces(), "its returns do not fall into rings");
    PlanarScan safety, strict;
    virtualizer.project(0, virtual_from_cloud, {{Profile::safety, &safety}, {Profile::strict, &strict}});
    const auto found = search(cloud, mount, {}, band, [&](std::size_t i) {
      const CloudPoint& p = cloud.points()[i];
      return virtual_from_cloud *
             ((moves ? motion.at(static_cast<double>(p.time)) : Pose::Identity()) * place_of(p));
    });
    for (std::size_t i = 0; i < found.size(); ++i) {
      ASSERT_EQ(strict.statuses[i], BeamStatus::invalid) << "points prove nothing";
      ASSERT_EQ(safety.statuses[i] == BeamStatus::hit, found[i].range < 100) << i;
      if (found[i].range > 100) continue;
      ASSERT_NEAR(static_cast<double>(safety.ranges[i]), found[i].range, 1e-3) << i;
      ASSERT_EQ(static_cast<double>(safety.intensities[i]), found[i].intensity) << i;
    }
  }
}

}  // namespace
}  // namespace lidard
