// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What the users of a LaserScan require of every scan that a merge or a virtual scan gives.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/angle.h"
#include "core/merge/merger.h"
#include "core/virtual/virtualizer.h"
#include "test/sim/world/flat_world.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

/// The count that slam_toolbox (noetic: laser_utils.cpp, Karto.h) expects of a scan.
std::size_t karto_count(const PlanarScan& scan) {
  const double span = static_cast<double>(scan.angle_max) - static_cast<double>(scan.angle_min);
  const double increment = static_cast<double>(scan.angle_increment);
  const bool is_360 = std::abs(span - 2 * pi_d) < increment - 0.0000001 * 6.283;
  return static_cast<std::size_t>(std::lround(span / increment)) + (is_360 ? 0U : 1U);
}

/// What Cartographer's CHECKs (cartographer_ros, msg_conversion.cc) abort on.
void expect_cartographer_takes(const PlanarScan& scan) {
  EXPECT_GE(scan.range_min, 0.0F);
  EXPECT_GE(scan.range_max, scan.range_min);
  EXPECT_GT(scan.angle_increment, 0.0F);
  EXPECT_GT(scan.angle_max, scan.angle_min);
  EXPECT_TRUE(scan.intensities.empty() || scan.intensities.size() == scan.ranges.size());
  // The stamp is the instant to which all beams were brought, so none of them is later.
  EXPECT_EQ(scan.time_increment, 0.0F);
}

void expect_consumers_take(const PlanarScan& scan, std::size_t beams) {
  EXPECT_EQ(violation(scan), nullptr) << violation(scan);
  EXPECT_EQ(scan.ranges.size(), beams);
  EXPECT_EQ(karto_count(scan), scan.ranges.size());
  expect_cartographer_takes(scan);
}

/// A scanner's sweep of a room with two boxes.
PlanarScan sweep_at(Stamp stamp, double yaw) {
  sim::FlatWorld world;
  world.add_box({0, 0}, {9, 6}, 0);
  world.add_box({3, 1}, {0.4, 0.3}, 0.5);
  sim::FlatScanner scanner;
  scanner.yaw = yaw;
  scanner.increment = pi_d / 360;
  sim::Rng rng(1);
  PlanarScan scan;
  scanner.measure(world, rng, scan);
  scan.stamp = stamp;
  return scan;
}

/// All profiles of one merge of two scanners.
struct AllProfiles {
  explicit AllProfiles(const ScanGridSpec& spec) {
    grid = make_grid(spec).value();
    MergeSettings settings;
    settings.visibility = true;
    merger.emplace(grid, HeightBand{}, 2, settings);
  }
  bool add(std::size_t source, Stamp stamp) {
    const double yaw = source == 0 ? 0.0 : pi_d;
    return merger->add(source, sweep_at(stamp, yaw), make_pose({0, 0, 0}, {0, 0, yaw}));
  }
  void merge() {
    merger->merge({t0 + ms(1)}, {1, 1},
                  {{Profile::strict, &scans[0]}, {Profile::safety, &scans[1]}, {Profile::flatten, &scans[2]}},
                  nullptr);
  }
  ScanGrid grid;
  std::optional<Merger> merger;
  PlanarScan scans[3];
};

ScanGridSpec circle(std::size_t beams) {
  ScanGridSpec spec;
  spec.beams = beams;
  spec.range_max = 30;
  return spec;
}

TEST(Consumers, TakeEveryProfileWhateverTheNumberOfBeams) {
  for (std::size_t n = 90; n <= 20000; n += n < 1000 ? 77 : 1901) {
    AllProfiles all(circle(n));
    all.add(0, t0);
    ASSERT_TRUE(all.add(1, t0 + ms(1)));
    all.merge();
    for (const PlanarScan& scan : all.scans) {
      SCOPED_TRACE(n);
      expect_consumers_take(scan, n);
    }
  }
}

TEST(Consumers, TakePartsOfACircleAlso) {
  for (const double half : {0.6, 1.57, 2.36, 3.1}) {
    ScanGridSpec spec;
    spec.angle_min = -half;
    spec.angle_max = half;
    spec.angle_increment = 0.0058;
    spec.range_max = 30;
    AllProfiles all(spec);
    all.add(0, t0);
    ASSERT_TRUE(all.add(1, t0 + ms(1)));
    all.merge();
    for (const PlanarScan& scan : all.scans) {
      SCOPED_TRACE(half);
      expect_consumers_take(scan, all.grid.beams);
    }
  }
}

TEST(Consumers, TakeVirtualScans) {
  Cloud cloud;
  cloud.stamp = t0;
  cloud.end = t0 + ms(100);
  for (int i = 0; i < 3600; ++i) {
    const double angle = i * pi_d / 1800;
    cloud.points_bytes.resize(cloud.points_bytes.size() + sizeof(CloudPoint));
    cloud.points()[cloud.size() - 1] = {
        static_cast<float>(5 * std::cos(angle)), static_cast<float>(5 * std::sin(angle)), 0, 1, 0, 0};
  }
  for (std::size_t n = 90; n <= 20000; n += 371) {
    Virtualizer virtualizer(make_grid(circle(n)).value(), {-0.1, 0.1});
    PlanarScan scan;
    virtualizer.set_cloud(cloud, Pose::Identity());
    virtualizer.project(0, Pose::Identity(), {{Profile::flatten, &scan}});
    SCOPED_TRACE(n);
    expect_consumers_take(scan, n);
  }
}

}  // namespace
}  // namespace lidard
