// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/scan.h"

#include <gtest/gtest.h>

TEST(PlanarScan, FreshScanHasNoViolationOnceItHasAnglesAndLimits) {
  lidard::PlanarScan scan;
  scan.reset(3);
  scan.set_angles(-1.0F, 0.5F);
  scan.range_max = 10;
  EXPECT_EQ(lidard::violation(scan), nullptr);
  scan.ranges[1] = 11;
  EXPECT_NE(lidard::violation(scan), nullptr);
}

namespace lidard {
namespace {

TEST(AngleWindow, HoldsTheBeamsOfASectorOfTheCircleInTheOrderOfTheScan) {
  struct Case {
    double first, last;          // deg
    BeamWindow all_round, wide;  // of a scan from -180 to 179 deg, and of one from -135 to 135, each deg
  };
  for (const Case& one :
       {Case{0, 360, {0, 360}, {0, 271}}, Case{-180, 180, {0, 360}, {0, 271}},
        Case{90, 135, {270, 46}, {225, 46}}, Case{270, 300, {90, 31}, {45, 31}},
        Case{-370, -350, {170, 21}, {125, 21}}, Case{140, -140, {0, 360, 41, 279}, {}},
        Case{90, 270, {0, 360, 91, 179}, {0, 271, 46, 179}}, Case{130, 140, {310, 11}, {265, 6}}}) {
    const Sector sector = sector_between(one.first * rad_per_deg, one.last * rad_per_deg);
    const auto expect = [&](const BeamWindow& found, const BeamWindow& wanted) {
      EXPECT_EQ(found.first, wanted.first) << one.first;
      EXPECT_EQ(found.count, wanted.count) << one.first;
      EXPECT_EQ(found.gap_first, wanted.gap_first) << one.first;
      EXPECT_EQ(found.gap_count, wanted.gap_count) << one.first;
    };
    expect(beams_inside(sector, -pi_d, rad_per_deg, 360), one.all_round);
    expect(beams_inside(sector, -135 * rad_per_deg, rad_per_deg, 271), one.wide);
  }
  EXPECT_EQ(sector_between(1.0, 1.0).width(), 0);
  EXPECT_EQ(sector_between(-1e300, 1e300).is_all(), true);
  // A limit alone leaves out what lies before or behind it, and no beam comes round from the other side.
  EXPECT_EQ(beams_inside(sector_between({}, 0.0), 0.01, 0.01, 100).count, 0U);
  EXPECT_EQ(beams_inside(sector_between(0.0, {}), -pi_d, rad_per_deg, 360).count, 180U);
  EXPECT_EQ(beams_inside(sector_between({}, 0.0), pi_d, -rad_per_deg, 360).first, 180U);
}

TEST(PlanarScan, BeamsKeepTheirAnglesTimesAndEchoesInReversedOrder) {
  PlanarScan scan;
  scan.stamp = Stamp{1'000'000'000};
  scan.time_increment = 0.25F;
  scan.reset(3, 2);
  scan.set_angles(1.0F, -0.5F);
  scan.range_max = 10;
  scan.flags = {1, 2, 3};
  for (std::size_t i = 0; i < 5; ++i) scan.set_hit(i, static_cast<float>(i + 1)), scan.intensities[i] = 7.0F;
  PlanarScan turned = scan;
  turned.reverse();
  EXPECT_EQ(violation(turned), nullptr);
  EXPECT_EQ(turned.angle_min, 0.0F);
  EXPECT_EQ(turned.angle_max, 1.0F);
  EXPECT_EQ(turned.angle_increment, 0.5F);
  EXPECT_EQ(turned.time_increment, -0.25F);
  EXPECT_EQ(turned.stamp.ns, 1'500'000'000);
  for (std::size_t beam = 0; beam < 3; ++beam) {
    EXPECT_EQ(turned.flags[beam], scan.flags[2 - beam]);
    for (std::size_t echo = 0; echo < 2; ++echo) {
      EXPECT_EQ(turned.statuses[turned.index(beam, echo)], scan.statuses[scan.index(2 - beam, echo)]);
      EXPECT_EQ(turned.intensities[turned.index(beam, echo)], scan.intensities[scan.index(2 - beam, echo)]);
    }
  }
  turned.reverse();
  EXPECT_EQ(turned.stamp, scan.stamp);
  EXPECT_EQ(turned.flags, scan.flags);
}

}  // namespace
}  // namespace lidard
