// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/scan_grid.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lidard {
namespace {

constexpr double pi = 3.14159265358979323846;

ScanGrid grid_of(const ScanGridSpec& spec) {
  const auto grid = make_grid(spec);
  EXPECT_TRUE(grid) << grid.reason();
  return grid ? *grid : ScanGrid{};
}

/// The count that slam_toolbox (noetic, laser_utils.cpp and Karto.h) expects of a scan, in its own float
/// arithmetic.
std::size_t karto_count(const PlanarScan& scan) {
  const double span = static_cast<double>(scan.angle_max) - static_cast<double>(scan.angle_min);
  const double increment = static_cast<double>(scan.angle_increment);
  const bool is_360 = std::abs(span - 2 * pi) < increment - (0.0000001 * 6.283);
  return static_cast<std::size_t>(std::lround(span / increment)) + (is_360 ? 0U : 1U);
}

TEST(ScanGrid, SatisfiesSlamToolboxForEveryFullCircle) {
  for (std::size_t n = 90; n <= 20000; ++n) {
    ScanGridSpec spec;
    spec.beams = n;
    PlanarScan scan;
    grid_of(spec).prepare(scan, false);
    ASSERT_EQ(scan.beams, n);
    // With a step of 2 pi / n the span misses the full turn by one increment, which Karto counts as open.
    ASSERT_EQ(karto_count(scan), n) << n;
  }
}

TEST(ScanGrid, SatisfiesSlamToolboxForPartialCircles) {
  for (double half = 0.5; half < 3.1; half += 0.07) {
    for (double increment = 0.0017; increment < 0.03; increment += 0.0011) {
      ScanGridSpec spec;
      spec.angle_min = -half;
      spec.angle_max = half;
      spec.angle_increment = increment;
      PlanarScan scan;
      grid_of(spec).prepare(scan, false);
      ASSERT_EQ(karto_count(scan), scan.ranges.size()) << half << " " << increment;
    }
  }
}

TEST(ScanGrid, TakesTheDefaultsOfIraLaserTools) {
  ScanGridSpec spec;
  spec.angle_min = -2.36;
  spec.angle_max = 2.36;
  spec.angle_increment = 0.0058;
  PlanarScan scan;
  grid_of(spec).prepare(scan, false);
  EXPECT_EQ(scan.beams, 815U);
  EXPECT_NEAR(scan.angle_max, 2.3612, 1e-5);
  EXPECT_EQ(karto_count(scan), 815U);
}

TEST(ScanGrid, FindsTheNearestBeamAcrossTheSeam) {
  ScanGridSpec spec;
  spec.beams = 360;
  const ScanGrid grid = grid_of(spec);
  ASSERT_TRUE(grid.full_circle);
  EXPECT_EQ(grid.nearest(-pi), 0U);
  EXPECT_EQ(grid.nearest(pi), 0U);
  EXPECT_EQ(grid.nearest(pi - 0.001), 0U);
  EXPECT_EQ(grid.nearest(pi - 0.01), 359U);
  EXPECT_EQ(grid.nearest(0), 180U);
  EXPECT_EQ(grid.nearest(2 * pi), 180U);
}

TEST(ScanGrid, KeepsPointsAtTheEndsOfAPartialSpanAndDropsThoseBeyond) {
  ScanGridSpec spec;
  spec.angle_min = -2.0;
  spec.angle_max = 2.0;
  spec.angle_increment = 0.01;
  const ScanGrid grid = grid_of(spec);
  ASSERT_EQ(grid.beams, 401U);
  EXPECT_EQ(grid.nearest(2.0), 400U);
  EXPECT_EQ(grid.nearest(-2.0), 0U);
  EXPECT_EQ(grid.nearest(-2.004), 0U);
  EXPECT_EQ(grid.nearest(-2.006), grid.beams);
  EXPECT_EQ(grid.nearest(2.006), grid.beams);
  EXPECT_EQ(grid.nearest(pi), grid.beams);
}

TEST(ScanGrid, EveryAngleOfASpanHasAnIndexInside) {
  for (const double increment : {pi / 180, pi / 360, pi / 720, 0.01, 0.005}) {
    ScanGridSpec spec;
    spec.angle_increment = increment;
    const ScanGrid grid = grid_of(spec);
    for (double a = -7; a < 7; a += 0.00037) ASSERT_LT(grid.nearest(a), grid.beams);
  }
}

TEST(ScanGrid, SaysWhatIsWrong) {
  const auto error_of = [](auto change) {
    ScanGridSpec spec;
    change(spec);
    const auto grid = make_grid(spec);
    EXPECT_FALSE(grid);
    return grid.reason();
  };
  EXPECT_NE(error_of([](auto& s) { s.angle_increment = 0; }).find("angle_increment"), std::string::npos);
  EXPECT_NE(error_of([](auto& s) { s.angle_increment = 1e-9; }).find("increments"), std::string::npos);
  EXPECT_NE(error_of([](auto& s) { s.angle_max = -4; }).find("angle_max"), std::string::npos);
  EXPECT_NE(error_of([](auto& s) {
              s.angle_min = -3.2, s.angle_max = 3.2;
              s.beams = 1000;
            }).find("full turn"),
            std::string::npos);
  EXPECT_NE(error_of([](auto& s) { s.range_min = -1; }).find("range_min"), std::string::npos);
  EXPECT_NE(error_of([](auto& s) { s.range_max = 0; }).find("range_max"), std::string::npos);
  EXPECT_NE(error_of([](auto& s) { s.range_max = std::nan(""); }).find("finite"), std::string::npos);
  EXPECT_NE(error_of([](auto& s) { s.beams = 1; }).find("beams"), std::string::npos);
  EXPECT_NE(error_of([](auto& s) { s.beams = 10, s.angle_increment = 1; }).find("both"), std::string::npos);
}

}  // namespace
}  // namespace lidard
