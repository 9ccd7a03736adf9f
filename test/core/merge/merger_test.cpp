// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/merger.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/virtual/virtualizer.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

ScanGrid full_circle(std::size_t beams, double range_max = 50) {
  ScanGridSpec spec;
  spec.beams = beams;
  spec.range_max = range_max;
  return make_grid(spec).value();
}

/// A scan of 181 beams over +-90 deg whose hits all lie at `range`.
PlanarScan arc(double range, Stamp stamp, bool intensities = true) {
  PlanarScan scan;
  scan.reset(181, 1, intensities);
  scan.set_angles(static_cast<float>(-pi_d / 2), static_cast<float>(pi_d / 180));
  scan.range_max = 60;
  scan.scan_time = 0.03F;
  scan.stamp = stamp;
  for (std::size_t i = 0; i < scan.beams; ++i) {
    scan.set_hit(i, static_cast<float>(range));
    if (intensities) scan.intensities[i] = static_cast<float>(i);
  }
  return scan;
}

/// Merges all sources at the newest of their stamps, as if the vehicle stood.
void merge(Merger& merger, std::size_t sources, const std::vector<MergedScan>& outputs,
           Cloud* cloud = nullptr) {
  MergeMoment moment;
  for (std::size_t s = 0; s < sources; ++s) {
    if (const auto times = merger.times(s)) moment.at = std::max(moment.at, times->first);
  }
  merger.merge(moment, std::vector<char>(sources, 1), outputs, cloud);
}
void merge(Merger& merger, std::size_t sources, PlanarScan& scan, Cloud* cloud = nullptr) {
  merge(merger, sources, {{Profile::flatten, &scan}}, cloud);
}

TEST(Merger, PutsEveryHitOnTheBeamNearestToIt) {
  Merger merger(full_circle(360), {}, 1);
  PlanarScan scan = arc(5, t0);
  scan.set_without_hit(90, BeamStatus::invalid);
  scan.set_without_hit(91, BeamStatus::none);
  ASSERT_TRUE(merger.add(0, scan, Pose::Identity()));
  PlanarScan out;
  merge(merger, 1, out);
  EXPECT_EQ(violation(out), nullptr);
  for (std::size_t i = 0; i < out.beams; ++i) {
    const int degree = static_cast<int>(i) - 180;
    const bool hit = std::abs(degree) <= 90 && degree != 0 && degree != 1;
    EXPECT_EQ(out.statuses[i], hit ? BeamStatus::hit : BeamStatus::none) << degree;
    if (!hit) continue;
    EXPECT_NEAR(out.ranges[i], 5, 1e-5);
    EXPECT_EQ(out.intensities[i], static_cast<float>(degree + 90));
  }
  EXPECT_EQ(out.stamp, t0);
  EXPECT_FLOAT_EQ(out.scan_time, 0.03F);
}

TEST(Merger, MovesPointsByTheMountPoseAndIgnoresTheirHeight) {
  Merger merger(full_circle(360), {}, 1);
  PlanarScan scan = arc(4, t0);
  for (std::size_t i = 0; i < scan.beams; ++i) {
    if (i != 90) scan.set_without_hit(i, BeamStatus::none);
  }
  ASSERT_TRUE(merger.add(0, scan, make_pose({1, 2, 0.35}, {0, 0, pi_d / 2})));
  PlanarScan out;
  merge(merger, 1, out);
  const auto beam = full_circle(360).nearest(std::atan2(6, 1));
  EXPECT_EQ(out.statuses[beam], BeamStatus::hit);
  EXPECT_NEAR(out.ranges[beam], std::hypot(1, 6), 1e-5);
}

TEST(Merger, HeightBandLeavesOutWhatATiltedScannerSeesOnTheFloor) {
  Merger merger(full_circle(360), {-0.1, 0.1}, 1);
  ASSERT_TRUE(merger.add(0, arc(5, t0), make_pose({0, 0, 0}, {0, 0.2, 0})));
  PlanarScan out;
  merge(merger, 1, out);
  EXPECT_EQ(out.statuses[180], BeamStatus::none);  // 5 m ahead the beam is 1 m below
  EXPECT_EQ(out.statuses[90], BeamStatus::hit);    // sideways it is level
}

TEST(Merger, NearestOfSeveralSourcesWinsWhateverTheirOrder) {
  for (const bool swapped : {false, true}) {
    Merger merger(full_circle(360), {}, 2);
    EXPECT_TRUE(merger.add(swapped ? 1 : 0, arc(5, t0), Pose::Identity()));
    EXPECT_TRUE(merger.add(swapped ? 0 : 1, arc(3, t0 + ms(5)), Pose::Identity()));
    PlanarScan out;
    merge(merger, 2, out);
    EXPECT_FLOAT_EQ(out.ranges[180], 3);
    EXPECT_EQ(out.stamp, t0 + ms(5));
  }
}

TEST(Merger, CountsSweepsThatAreReplacedBeforeTheyAreUsed) {
  Merger merger(full_circle(360), {}, 2);
  merger.add(0, arc(5, t0), Pose::Identity());
  merger.add(0, arc(4, t0 + ms(30)), Pose::Identity());
  EXPECT_EQ(merger.superseded(), 1U);
  PlanarScan out;
  merge(merger, 2, out);
  EXPECT_FLOAT_EQ(out.ranges[180], 4);
  merger.add(0, arc(5, t0 + ms(60)), Pose::Identity());
  EXPECT_EQ(merger.superseded(), 1U);
}

TEST(Merger, UsesTheSourcesThatItIsAskedToUse) {
  Merger merger(full_circle(360), {}, 2);
  merger.add(0, arc(5, t0), Pose::Identity());
  merger.add(1, arc(2, t0 + ms(1)), Pose::Identity());
  PlanarScan out;
  const std::vector<MergedScan> outputs = {{Profile::flatten, &out}};
  merger.merge({t0 + ms(2)}, {1, 0}, outputs, nullptr);
  EXPECT_FLOAT_EQ(out.ranges[180], 5);
  EXPECT_EQ(out.stamp, t0 + ms(2));
  merger.merge({t0 + ms(3)}, {1, 1}, outputs, nullptr);
  EXPECT_FLOAT_EQ(out.ranges[180], 2);
  merger.merge({t0 + ms(4)}, {0, 0}, outputs, nullptr);
  EXPECT_EQ(out.statuses[180], BeamStatus::none);
}

TEST(Merger, SweepsThatAreNotNewerAreCountedAndNotUsed) {
  Merger merger(full_circle(360), {}, 1);
  ASSERT_TRUE(merger.add(0, arc(5, t0 + ms(30)), Pose::Identity()));
  EXPECT_FALSE(merger.add(0, arc(4, t0), Pose::Identity()));
  EXPECT_FALSE(merger.add(0, arc(4, t0 + ms(30)), Pose::Identity()));
  EXPECT_EQ(merger.out_of_order(), 2U);
  PlanarScan out;
  merge(merger, 1, out);
  EXPECT_FLOAT_EQ(out.ranges[180], 5);
}

TEST(Merger, InputThatStartsAgainIsNotTakenForOldSweeps) {
  Merger merger(full_circle(360), {}, 1);
  ASSERT_TRUE(merger.add(0, arc(5, t0 + std::chrono::seconds(100)), Pose::Identity()));
  PlanarScan out;
  merge(merger, 1, out);
  ASSERT_TRUE(merger.add(0, arc(5, t0), Pose::Identity()));
  merge(merger, 1, out);
  EXPECT_EQ(out.stamp, t0);
}

TEST(Merger, IntensitiesAreLeftOutWhenASourceHasNone) {
  Merger merger(full_circle(360), {}, 2);
  merger.add(0, arc(5, t0), Pose::Identity());
  ASSERT_TRUE(merger.add(1, arc(5, t0, false), Pose::Identity()));
  PlanarScan out;
  Cloud cloud;
  merge(merger, 2, out, &cloud);
  EXPECT_TRUE(out.intensities.empty());
  EXPECT_EQ(cloud.size(), 362U);
  EXPECT_EQ(static_cast<int>(cloud.points()[361].ring), 1);
}

MergeSettings with_visibility() {
  MergeSettings settings;
  settings.visibility = true;
  return settings;
}

TEST(Merger, GivesAllProfilesFromOneMerge) {
  Merger merger(full_circle(360, 30), {}, 1, with_visibility());
  PlanarScan scan = arc(5, t0);
  for (std::size_t i = 86; i <= 94; ++i) scan.set_without_hit(i, BeamStatus::none);
  scan.set_without_hit(45, BeamStatus::invalid);
  ASSERT_TRUE(merger.add(0, scan, Pose::Identity()));
  PlanarScan strict, safety, flat;
  Cloud cloud;
  merge(merger, 1, {{Profile::strict, &strict}, {Profile::safety, &safety}, {Profile::flatten, &flat}},
        &cloud);
  for (const PlanarScan* out : {&strict, &safety, &flat}) {
    EXPECT_EQ(violation(*out), nullptr);
    EXPECT_EQ(out->stamp, t0);
    EXPECT_FLOAT_EQ(out->ranges[200], 5);
    EXPECT_FLOAT_EQ(out->intensities[200], 110);
  }
  EXPECT_EQ(cloud.size(), 171U);
  EXPECT_EQ(strict.statuses[180], BeamStatus::none);
  EXPECT_EQ(safety.statuses[180], BeamStatus::none);
  EXPECT_EQ(strict.statuses[176], BeamStatus::none);     // a beam of the scanner's own passed there
  EXPECT_EQ(strict.statuses[135], BeamStatus::invalid);  // the device did not vouch for it
  EXPECT_EQ(flat.statuses[135], BeamStatus::none);
  EXPECT_EQ(strict.statuses[0], BeamStatus::invalid);  // behind, where the scanner does not look
  EXPECT_EQ(flat.statuses[0], BeamStatus::none);
}

TEST(Merger, ReturnsInsideTheVehiclesOutlineAreLeftOutInEveryProfile) {
  Merger merger(full_circle(360, 30), {}, 1, with_visibility());
  PlanarScan strict, flat;
  ASSERT_TRUE(merger.add(0, arc(5, t0), Pose::Identity()));
  merge(merger, 1, {{Profile::strict, &strict}});
  EXPECT_EQ(strict.statuses[180], BeamStatus::hit) << "no outline yet";
  merger.set_footprint(
      Footprint({{-4, -1}, {0, -1}, {0, 1}, {-4, 1}}).transformed(make_pose({5.5, 0, 0}, {0, 0, 0})));
  ASSERT_TRUE(merger.add(0, arc(5, t0 + ms(30)), Pose::Identity()));
  merge(merger, 1, {{Profile::strict, &strict}, {Profile::flatten, &flat}});
  EXPECT_NE(strict.statuses[180], BeamStatus::hit);
  EXPECT_NE(flat.statuses[180], BeamStatus::hit);
  EXPECT_EQ(strict.statuses[240], BeamStatus::hit);
  EXPECT_EQ(flat.statuses[240], BeamStatus::hit);
}

TEST(Merger, SectorOfASourceThatIsNotUsedIsUnknown) {
  Merger merger(full_circle(360, 30), {}, 2, with_visibility());
  merger.add(0, arc(5, t0), Pose::Identity());
  merger.add(1, arc(7, t0 + ms(5)), make_pose({0, 0, 0}, {0, 0, pi_d}));
  PlanarScan strict;
  merge(merger, 2, {{Profile::strict, &strict}});
  EXPECT_FLOAT_EQ(strict.ranges[0], 7);
  merger.merge({t0 + ms(6)}, {1, 0}, {{Profile::strict, &strict}}, nullptr);
  EXPECT_EQ(strict.statuses[0], BeamStatus::invalid);
  EXPECT_FLOAT_EQ(strict.ranges[180], 5);
}

TEST(Virtualizer, ProjectsOnlyTheBandOfTheVirtualFrame) {
  Cloud cloud;
  cloud.stamp = t0;
  cloud.end = t0 + ms(100);
  const std::vector<CloudPoint> points = {{10, 0, -1.5F, 7, 0, 0},  // 0.5 m above ground: in the band
                                          {5, 0, -2.0F, 7, 0, 0},   // ground
                                          {0, 8, -1.45F, 9, 1, 0},  // in the band
                                          {NAN, 0, -1.5F, 7, 0, 0}};
  cloud.points_bytes.resize(points.size() * sizeof(CloudPoint));
  std::copy(points.begin(), points.end(), cloud.points());
  Virtualizer virtualizer(full_circle(360), {-0.1, 0.1});
  const Pose sensor_in_base = make_pose({0, 0, 2}, {0, 0, 0});
  const Pose virtual_in_base = make_pose({1.5, 0, 0.5}, {0, 0, 0});
  PlanarScan scan;
  virtualizer.set_cloud(cloud, sensor_in_base);
  virtualizer.project(0, virtual_in_base.inverse() * sensor_in_base, {{Profile::flatten, &scan}});
  EXPECT_EQ(violation(scan), nullptr);
  EXPECT_FLOAT_EQ(scan.ranges[180], 8.5F);
  EXPECT_EQ(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::hit), 2);
  EXPECT_EQ(scan.stamp, t0);
  EXPECT_FLOAT_EQ(scan.scan_time, 0.1F);
}

TEST(Virtualizer, TiltedFrameSeesTheAnalyticLine) {
  // A wall 10 m ahead of a frame pitched down by 0.3 rad: straight ahead its plane meets the wall at 10 / cos
  // 0.3.
  const Pose tilted = make_pose({0, 0, 0}, {0, 0.3, 0});
  Cloud cloud;
  for (int i = -20000; i <= 20000; ++i) {
    const double y = i * 0.001;
    const CloudPoint p{10, static_cast<float>(y), static_cast<float>(-10 * std::tan(0.3)), 1, 0, 0};
    cloud.points_bytes.resize(cloud.points_bytes.size() + sizeof(CloudPoint));
    cloud.points()[cloud.size() - 1] = p;
  }
  Virtualizer virtualizer(full_circle(720), {-0.05, 0.05});
  PlanarScan scan;
  virtualizer.set_cloud(cloud, Pose::Identity());
  virtualizer.project(0, tilted.inverse(), {{Profile::flatten, &scan}});
  for (std::size_t i = 300; i <= 420; ++i) {
    const double beam = full_circle(720).angle(i);
    ASSERT_EQ(scan.statuses[i], BeamStatus::hit) << i;
    // Nearest point within half a beam.
    EXPECT_NEAR(scan.ranges[i], 10 / std::cos(0.3) / std::cos(beam), 0.04) << i;
  }
}

}  // namespace
}  // namespace lidard
