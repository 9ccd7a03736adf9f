// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/merger.h"

#include <gtest/gtest.h>

#include "test/sim/world/circle.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

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

TEST(Merger, CountsSweepsThatAreReplacedBeforeTheyAreUsed) {
  Merger merger(test::full_circle(360), {}, 2);
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
  Merger merger(test::full_circle(360), {}, 2);
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
  Merger merger(test::full_circle(360), {}, 1);
  ASSERT_TRUE(merger.add(0, arc(5, t0 + ms(30)), Pose::Identity()));
  EXPECT_FALSE(merger.add(0, arc(4, t0), Pose::Identity()));
  EXPECT_FALSE(merger.add(0, arc(4, t0 + ms(30)), Pose::Identity()));
  EXPECT_EQ(merger.out_of_order(), 2U);
  PlanarScan out;
  merge(merger, 1, out);
  EXPECT_FLOAT_EQ(out.ranges[180], 5);
}

TEST(Merger, InputThatStartsAgainIsNotTakenForOldSweeps) {
  Merger merger(test::full_circle(360), {}, 1);
  ASSERT_TRUE(merger.add(0, arc(5, t0 + std::chrono::seconds(100)), Pose::Identity()));
  PlanarScan out;
  merge(merger, 1, out);
  ASSERT_TRUE(merger.add(0, arc(5, t0), Pose::Identity()));
  merge(merger, 1, out);
  EXPECT_EQ(out.stamp, t0);
}

MergeSettings with_visibility() {
  MergeSettings settings;
  settings.visibility = true;
  return settings;
}

TEST(Merger, GivesAllProfilesFromOneMerge) {
  Merger merger(test::full_circle(360, 30), {}, 1, with_visibility());
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
  Merger merger(test::full_circle(360, 30), {}, 1, with_visibility());
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
  Merger merger(test::full_circle(360, 30), {}, 2, with_visibility());
  merger.add(0, arc(5, t0), Pose::Identity());
  merger.add(1, arc(7, t0 + ms(5)), make_pose({0, 0, 0}, {0, 0, pi_d}));
  PlanarScan strict;
  merge(merger, 2, {{Profile::strict, &strict}});
  EXPECT_FLOAT_EQ(strict.ranges[0], 7);
  merger.merge({t0 + ms(6)}, {1, 0}, {{Profile::strict, &strict}}, nullptr);
  EXPECT_EQ(strict.statuses[0], BeamStatus::invalid);
  EXPECT_FLOAT_EQ(strict.ranges[180], 5);
}

}  // namespace
}  // namespace lidard
