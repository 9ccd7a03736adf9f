// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/scan_grid.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test/sim/world/units.h"

namespace lidard {
namespace {

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
  const bool is_360 = std::abs(span - 2 * pi_d) < increment - (0.0000001 * 6.283);
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
  EXPECT_EQ(grid.nearest(-pi_d), 0U);
  EXPECT_EQ(grid.nearest(pi_d), 0U);
  EXPECT_EQ(grid.nearest(pi_d - 0.001), 0U);
  EXPECT_EQ(grid.nearest(pi_d - 0.01), 359U);
  EXPECT_EQ(grid.nearest(0), 180U);
  EXPECT_EQ(grid.nearest(2 * pi_d), 180U);
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
  EXPECT_EQ(grid.nearest(pi_d), grid.beams);
}

TEST(ScanGrid, EveryAngleOfASpanHasAnIndexInside) {
  for (const double increment : {pi_d / 180, pi_d / 360, pi_d / 720, 0.01, 0.005}) {
    ScanGridSpec spec;
    spec.angle_increment = increment;
    const ScanGrid grid = grid_of(spec);
    for (double a = -7; a < 7; a += 0.00037) ASSERT_LT(grid.nearest(a), grid.beams);
  }
}

TEST(ScanGrid, BeamsThatAreAskedForReachFromTheFirstAngleToTheLast) {
  for (const std::size_t beams : {2U, 3U, 100U, 815U, 5000U}) {
    for (const double max : {-0.2, 0.4, 2.9}) {
      ScanGridSpec spec;
      spec.angle_min = -1.7;
      spec.angle_max = max;
      spec.beams = beams;
      const ScanGrid grid = grid_of(spec);
      ASSERT_FALSE(grid.full_circle);
      EXPECT_EQ(grid.beams, beams);
      EXPECT_NEAR(grid.angle(0), -1.7, 1e-12);
      EXPECT_NEAR(grid.angle(beams - 1), max, 1e-12) << beams;
      PlanarScan scan;
      grid.prepare(scan, true);
      EXPECT_EQ(violation(scan), nullptr);
      EXPECT_NEAR(scan.angle_max, max, 1e-5 * static_cast<double>(beams));
    }
  }
}

TEST(ScanGrid, AnIncrementIsKeptAndTheLastBeamIsTheOneNearestToTheEnd) {
  for (const double increment : {0.1, 0.013, 0.00777}) {
    for (const double max : {0.5, 1.234, 3.0}) {
      ScanGridSpec spec;
      spec.angle_min = -1;
      spec.angle_max = max;
      spec.angle_increment = increment;
      const ScanGrid grid = grid_of(spec);
      EXPECT_EQ(grid.increment, increment);
      EXPECT_LE(std::abs(grid.angle(grid.beams - 1) - max), increment / 2 + 1e-12);
    }
  }
}

TEST(ScanGrid, ASpanOfAFullTurnButForHalfABeamIsOne) {
  const auto full = [](double span) {
    ScanGridSpec spec;
    spec.angle_min = -pi_d;
    spec.angle_max = -pi_d + span;
    spec.angle_increment = 0.02;
    return grid_of(spec).full_circle;
  };
  EXPECT_TRUE(full(2 * pi_d));
  EXPECT_TRUE(full(2 * pi_d - 0.0099));
  EXPECT_TRUE(full(2 * pi_d + 0.0099));
  EXPECT_FALSE(full(2 * pi_d - 0.0101));
  ScanGridSpec spec;
  spec.angle_min = -pi_d;
  spec.angle_max = pi_d + 0.011;
  spec.angle_increment = 0.02;
  EXPECT_NE(make_grid(spec).reason().find("full turn"), std::string::npos);
}

TEST(ScanGrid, TheDefaultIsAQuarterOfADegreeOverAnySpan) {
  EXPECT_EQ(grid_of({}).beams, 1440U);
  ScanGridSpec half;
  half.angle_min = 0, half.angle_max = pi_d;
  EXPECT_EQ(grid_of(half).beams, 721U);
  EXPECT_NEAR(grid_of(half).increment, pi_d / 720, 1e-12);
}

TEST(ScanGrid, TheNearestBeamIsTheOneThatASearchOfAllBeamsFinds) {
  for (const bool full : {true, false}) {
    for (const double from : {-3.0, -0.4, 1.9}) {
      ScanGridSpec spec;
      spec.angle_min = from;
      spec.angle_max = full ? from + 2 * pi_d : from + 2.5;
      spec.angle_increment = 2 * pi_d / 250;
      if (spec.angle_max > 2 * pi_d) continue;
      const ScanGrid grid = grid_of(spec);
      for (double angle = -9; angle < 9; angle += 0.00713) {
        std::size_t nearest = grid.beams;
        double least = grid.increment / 2;
        for (std::size_t beam = 0; beam < grid.beams; ++beam) {
          const double off = std::abs(std::remainder(grid.angle(beam) - angle, 2 * pi_d));
          if (off < least) least = off, nearest = beam;
        }
        if (std::abs(least - grid.increment / 2) < 1e-6 && nearest < grid.beams) continue;
        ASSERT_EQ(grid.nearest(angle), nearest) << from << ' ' << angle;
      }
    }
  }
}

TEST(ScanGrid, CarriesTimesAndRangesIntoTheScan) {
  ScanGridSpec spec;
  spec.time_increment = 0.001, spec.scan_time = 0.08, spec.range_min = 0.3, spec.range_max = 40;
  for (const bool with_intensities : {true, false}) {
    PlanarScan scan;
    grid_of(spec).prepare(scan, with_intensities);
    EXPECT_EQ(scan.time_increment, 0.001F);
    EXPECT_EQ(scan.scan_time, 0.08F);
    EXPECT_EQ(scan.range_min, 0.3F);
    EXPECT_EQ(scan.range_max, 40.0F);
    EXPECT_EQ(scan.intensities.size(), with_intensities ? 1440U : 0U);
    for (const BeamStatus status : scan.statuses) ASSERT_EQ(status, BeamStatus::invalid);
  }
}

TEST(ScanGrid, LimitsHoldAtTheirEdges) {
  const auto fits = [](auto change) {
    ScanGridSpec spec;
    change(spec);
    const auto grid = make_grid(spec);
    const bool made = static_cast<bool>(grid);
    EXPECT_EQ(made, grid.reason().empty());
    return made;
  };
  EXPECT_TRUE(fits([](auto& s) { s.angle_min = -2 * pi_d, s.angle_max = 0; }));
  EXPECT_FALSE(fits([](auto& s) { s.angle_min = -2 * pi_d - 0.001, s.angle_max = 0; }));
  EXPECT_TRUE(fits([](auto& s) { s.angle_min = 0, s.angle_max = 2 * pi_d; }));
  EXPECT_FALSE(fits([](auto& s) { s.angle_min = 0.1, s.angle_max = 2 * pi_d + 0.001; }));
  EXPECT_FALSE(fits([](auto& s) { s.angle_min = s.angle_max = 1; }));
  EXPECT_TRUE(fits([](auto& s) { s.beams = 2; }));
  EXPECT_TRUE(fits([](auto& s) { s.range_min = 0; }));
  EXPECT_FALSE(fits([](auto& s) { s.range_min = s.range_max = 5; }));
  EXPECT_FALSE(fits([](auto& s) { s.time_increment = -1e-6; }));
  EXPECT_FALSE(fits([](auto& s) { s.scan_time = -1e-6; }));
  EXPECT_TRUE(fits([](auto& s) { s.angle_increment = 2 * pi_d / 32767; }));
  EXPECT_FALSE(fits([](auto& s) { s.angle_increment = 2 * pi_d / 32768; }));
  EXPECT_FALSE(fits([](auto& s) { s.angle_min = 0, s.angle_max = 0.01, s.angle_increment = 0.021; }));
  for (const double bad : {std::nan(""), HUGE_VAL}) {
    EXPECT_FALSE(fits([bad](auto& s) { s.angle_min = bad; }));
    EXPECT_FALSE(fits([bad](auto& s) { s.angle_max = bad; }));
    EXPECT_FALSE(fits([bad](auto& s) { s.range_min = bad; }));
    EXPECT_FALSE(fits([bad](auto& s) { s.range_max = bad; }));
    EXPECT_FALSE(fits([bad](auto& s) { s.time_increment = bad; }));
    EXPECT_FALSE(fits([bad](auto& s) { s.scan_time = bad; }));
    EXPECT_FALSE(fits([bad](auto& s) { s.angle_increment = bad; }));
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
