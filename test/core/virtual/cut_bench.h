// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/angle.h"
#include "core/virtual/virtualizer.h"
#include "test/sim/world/circle.h"
#include "test/sim/world/units.h"
#include "test/support/yard.h"

namespace lidard::test::cut {

constexpr double lidar_height = 2.0;
constexpr double plane_height = 0.5;

inline ScanGrid full_circle(std::size_t beams) { return test::full_circle(beams, 60); }

inline sim::Object wall(double x0, double y0, double x1, double y1, double z_max = 4, double z_min = 0) {
  sim::Object object;
  object.shape = sim::Wall{{x0, y0}, {x1, y1}, z_min, z_max};
  return object;
}

inline sim::Object box(const Eigen::Vector3d& center, const Eigen::Vector3d& size) {
  sim::Object object;
  object.shape = sim::Box{size};
  object.pose = make_pose(center, {0, 0, 0});
  return object;
}

inline sim::YardLidar lidar16() {
  sim::YardLidar lidar;
  lidar.elevations = sim::even_rings(16, -15, 15);
  lidar.pose = make_pose({0, 0, lidar_height}, {0, 0, 0});
  return lidar;
}

inline Cloud seen(const sim::Yard& yard, const sim::YardLidar& lidar) {
  sim::Rng rng(1);
  return sim::measure(yard, lidar, rng);
}

inline VirtualSettings settings_with_ground() {
  VirtualSettings settings;
  settings.visibility = true;
  settings.how.noise = 0.005;
  settings.ground.model = GroundModel::plane;
  settings.beams.no_return_free_range = 100;
  return settings;
}

/// A virtual frame of a cloud, and what is made of it.
struct Cut {
  Pose frame = make_pose({0, 0, plane_height}, {0, 0, 0});  // in the world
  VirtualSettings settings = settings_with_ground();
  HeightBand band;
  ScanGrid grid = full_circle(720);
  Footprint footprint;
  PlanarScan strict, safety;
  float covered_ahead = 0;

  void make(const Cloud& cloud, const Pose& lidar) {
    Virtualizer virtualizer(grid, band, 1, settings);
    virtualizer.set_footprint(footprint);
    virtualizer.set_cloud(cloud, lidar);
    virtualizer.project(0, frame.inverse() * lidar, {{Profile::strict, &strict}, {Profile::safety, &safety}});
    covered_ahead = virtualizer.visibility(0).covered(grid.nearest(0));
    EXPECT_EQ(violation(strict), nullptr);
    EXPECT_EQ(violation(safety), nullptr);
  }
  double range(const PlanarScan& scan, double angle) const {
    const std::size_t beam = grid.nearest(angle);
    return scan.statuses[beam] == BeamStatus::hit ? static_cast<double>(scan.ranges[beam]) : NAN;
  }
  std::size_t count(const PlanarScan& scan, BeamStatus status) const {
    return static_cast<std::size_t>(std::count(scan.statuses.begin(), scan.statuses.end(), status));
  }
};

}  // namespace lidard::test::cut
