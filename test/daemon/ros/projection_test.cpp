// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// laser_geometry, with which most ROS programs read a LaserScan, puts our merged scans back onto the walls.
#include <gtest/gtest.h>
#include <laser_geometry/laser_geometry.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <algorithm>

#include "core/base/angle.h"
#include "core/merge/merger.h"
#include "daemon/ros/messages/convert.h"
#include "test/sim/world/flat_world.h"
#include "test/sim/world/units.h"
#include "test/support/ros_samples.h"

namespace lidard {
namespace {

using sim::FlatScanner;
using sim::FlatWorld;

enum class Mount { upright, reversed, upside_down };

/// What a scanner sends that is mounted so; the pose says the rest.
PlanarScan as_mounted(const PlanarScan& upright, Mount mount) {
  PlanarScan scan = upright;
  if (mount == Mount::upright) return scan;
  std::reverse(scan.ranges.begin(), scan.ranges.end());
  std::reverse(scan.statuses.begin(), scan.statuses.end());
  if (mount == Mount::reversed) scan.set_angles(upright.angle_max, -upright.angle_increment);
  // Turned over it sees the same from right to left; its field is symmetric, so its angles are the same.
  return scan;
}

Pose pose_of(const FlatScanner& scanner, Mount mount) {
  return make_pose({scanner.at.x(), scanner.at.y(), 0},
                   {mount == Mount::upside_down ? pi_d : 0, 0, scanner.yaw});
}

/// The room of the paper on ira_laser_tools with more in it; a scanner on each front corner.
struct Scene {
  Scene() {
    world.add_box({0, 0}, {20, 12}, 0);
    world.add_box({2.5, 0}, {0.5, 0.5}, 0);
    world.add_box({6, 5}, {1, 0.4}, 0.6);
    world.add_box({-3, -6}, {0.3, 2}, -0.3);
    world.add_wall({3, -3}, {9, -8});
    for (const double side : {1.0, -1.0}) {
      FlatScanner scanner;
      scanner.at = {0, side};
      scanner.yaw = side * 45 * degree;
      scanner.increment = 0.25 * degree;
      scanner.range_max = 40;
      scanners.push_back(scanner);
    }
  }

  /// Distances from the walls, m, of the points that laser_geometry makes of the merged scan.
  std::vector<double> errors(Profile profile, Mount mount) const {
    ScanGridSpec spec;
    spec.beams = 1440;
    MergeSettings settings;
    settings.visibility = true;
    settings.how.noise = settings.source.noise = 0.001;
    Merger merger(make_grid(spec).value(), {}, scanners.size(), settings);
    merger.set_footprint(Footprint({{-4, -1}, {0, -1}, {0, 1}, {-4, 1}}));
    sim::Rng rng(1);
    PlanarScan measured, merged;
    for (std::size_t s = 0; s < scanners.size(); ++s) {
      scanners[s].measure(world, rng, measured);
      measured.stamp = {1'000'000'000};
      merger.add(s, as_mounted(measured, mount), pose_of(scanners[s], mount));
    }
    merger.merge({measured.stamp}, std::vector<char>(scanners.size(), 1), {{profile, &merged}}, nullptr);
    sensor_msgs::LaserScan message;
    test::to_message(merged, message);
    sensor_msgs::PointCloud2 cloud;
    laser_geometry::LaserProjection().projectLaser(message, cloud);
    std::vector<double> distances;
    for (sensor_msgs::PointCloud2ConstIterator<float> x(cloud, "x"); x != x.end(); ++x)
      distances.push_back(world.distance({static_cast<double>(x[0]), static_cast<double>(x[1])}));
    std::sort(distances.begin(), distances.end());
    return distances;
  }

  FlatWorld world;
  std::vector<FlatScanner> scanners;
};

class Projection : public ::testing::TestWithParam<Mount> {};

std::string name_of(const ::testing::TestParamInfo<Mount>& mount) {
  constexpr const char* names[] = {"Upright", "NegativeIncrement", "UpsideDown"};
  return names[static_cast<std::size_t>(mount.param)];
}

INSTANTIATE_TEST_SUITE_P(Mounts, Projection,
                         ::testing::Values(Mount::upright, Mount::reversed, Mount::upside_down), name_of);

/// All but the ends of walls seen at a slant: such a return stays at its range in the middle of its beam, and
/// `safety` ends a beam that passes shortly behind a return there.
TEST_P(Projection, PutsStrictAndSafetyScansBackOntoTheWalls) {
  for (const Profile profile : {Profile::strict, Profile::safety}) {
    const auto distances = Scene().errors(profile, GetParam());
    ASSERT_GT(distances.size(), 1000U);
    const auto far = std::upper_bound(distances.begin(), distances.end(), 0.005);
    EXPECT_LT(static_cast<double>(distances.end() - far), 0.01 * static_cast<double>(distances.size()));
    EXPECT_LT(distances.back(), 0.1);
  }
}

/// A return moved to the middle of its beam, as `flatten` has it, leaves a slanting wall by half a beam's
/// width.
TEST_P(Projection, PutsFlattenedScansBackOntoTheWallsWithinHalfABeam) {
  const auto distances = Scene().errors(Profile::flatten, GetParam());
  ASSERT_GT(distances.size(), 1000U);
  EXPECT_LT(distances[distances.size() / 2], 0.005);
  EXPECT_LT(distances.back(), 0.005 + 23.4 * 0.125 * degree);
}

}  // namespace
}  // namespace lidard
