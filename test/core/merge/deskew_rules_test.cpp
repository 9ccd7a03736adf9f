// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What a merge does when poses are missing, beams have no times, or scans hardly any beams.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "core/merge/merger.h"
#include "test/sim/world/circle.h"
#include "test/sim/world/units.h"
#include "test/support/allocations.h"

namespace lidard {
namespace {

/// Beams over 270 degrees, a return at 5 m in every one of them, in 60 ms.
PlanarScan sweep_of(std::size_t beams, Stamp stamp = t0, std::size_t echoes = 1) {
  PlanarScan scan;
  scan.reset(beams, echoes);
  scan.set_angles(static_cast<float>(-0.75 * pi_d),
                  beams > 1 ? static_cast<float>(1.5 * pi_d / static_cast<double>(beams - 1)) : 0);
  scan.range_max = 40;
  scan.stamp = stamp;
  scan.time_increment = 0.06F / static_cast<float>(beams);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) scan.set_hit(i, 5 + static_cast<float>(i / beams));
  return scan;
}

/// 50 Hz at 2 m/s along x and 1 rad/s, from -100 ms to `end`.
PoseTrack track_until(int end) {
  PoseTrack track;
  for (int t = -100; t <= end; t += 20)
    track.add(t0 + ms(t), make_pose({0.002 * t, 0, 0}, {0, 0, 0.001 * t}));
  return track;
}

MergeSettings with_visibility(EchoChoice echoes = EchoChoice::last) {
  MergeSettings settings;
  settings.visibility = true;
  settings.source.echoes = echoes;
  return settings;
}

struct Outputs {
  PlanarScan strict, flat;
  Cloud cloud;
  std::vector<MergedScan> list{{Profile::strict, &strict}, {Profile::flatten, &flat}};
};

TEST(DeskewRules, MotionIsCarriedOnFor50MillisecondsThenBeamsStayWhereTheyWereMeasured) {
  Merger merger(test::full_circle(720, 40), {}, 1, with_visibility());
  merger.add(0, sweep_of(541), Pose::Identity());
  Outputs out;
  const struct {
    int newest;
    SourceUse expected;
  } cases[] = {{80, SourceUse::deskewed},
               {60, SourceUse::deskewed},
               {20, SourceUse::extrapolated},
               {0, SourceUse::static_poses}};
  for (const auto& c : cases) {
    const PoseTrack track = track_until(c.newest);
    const MergeMoment moment{t0 + ms(60), &track};
    const MergeReport& report = merger.merge(moment, {1}, out.list, &out.cloud);
    EXPECT_EQ(report.sources[0], c.expected) << c.newest;
    EXPECT_EQ(report.deskewed, c.expected != SourceUse::static_poses);
    EXPECT_EQ(violation(out.strict), nullptr);
    EXPECT_EQ(out.cloud.size(), 541U);
    for (std::size_t i = 0; i < out.cloud.size(); ++i) ASSERT_TRUE(std::isfinite(out.cloud.points()[i].x));
  }
  // The last case stood: the first beam's return is where it was measured, on a circle around the origin.
  EXPECT_NEAR(std::hypot(out.cloud.points()[0].x, out.cloud.points()[0].y), 5, 1e-5);
}

TEST(DeskewRules, SourceWithoutPosesStandsBesideOneThatIsDeskewed) {
  Merger merger(test::full_circle(720, 40), {}, 2, with_visibility());
  merger.add(0, sweep_of(541), Pose::Identity());
  merger.add(1, sweep_of(541, t0 - ms(300)), Pose::Identity());  // before the oldest pose
  const PoseTrack track = track_until(80);
  Outputs out;
  const MergeReport& report = merger.merge({t0 + ms(60), &track}, {1, 1}, out.list, &out.cloud);
  EXPECT_EQ(report.sources[0], SourceUse::deskewed);
  EXPECT_EQ(report.sources[1], SourceUse::static_poses);
  merger.merge({t0 + ms(60), &track}, {1, 0}, out.list, &out.cloud);
  EXPECT_EQ(report.sources[1], SourceUse::not_used);
  EXPECT_EQ(out.cloud.size(), 541U);
}

TEST(DeskewRules, ScansOfOneBeamAndOfNoneDoNoHarm) {
  const PoseTrack track = track_until(80);
  for (const std::size_t beams : {0U, 1U, 2U}) {
    Merger merger(test::full_circle(360, 40), {}, 1, with_visibility());
    merger.set_footprint(Footprint({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}));
    PlanarScan scan = sweep_of(std::max<std::size_t>(beams, 1));
    if (beams == 0) scan.reset(0);
    merger.add(0, scan, make_pose({0.5, 0, 0}, {0, 0, 0}));
    Outputs out;
    const MergeReport& report = merger.merge({t0 + ms(60), &track}, {1}, out.list, &out.cloud);
    EXPECT_NE(report.sources[0], SourceUse::not_used);  // it delivered
    EXPECT_EQ(out.cloud.size(), beams);
    EXPECT_EQ(violation(out.strict), nullptr) << beams;
    EXPECT_EQ(std::count(out.strict.statuses.begin(), out.strict.statuses.end(), BeamStatus::none), 0);
  }
}

TEST(DeskewRules, ScansWithImpossibleTimesAreCountedAndNotUsed) {
  Merger merger(test::full_circle(360, 40), {}, 1, with_visibility());
  const float bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                       -1e-4F, 1e9F, 0.1F};
  int i = 0;
  for (const float between : bad) {
    PlanarScan scan = sweep_of(541, t0 + ms(++i));
    scan.time_increment = between;
    EXPECT_FALSE(merger.add(0, scan, Pose::Identity()));
    EXPECT_FALSE(merger.times(0));
  }
  EXPECT_EQ(merger.bad_times(), 5U);
  PlanarScan scan = sweep_of(541, t0);
  scan.time_increment = 0;  // measured at once, for all that is known
  EXPECT_TRUE(merger.add(0, scan, Pose::Identity()));
  EXPECT_EQ(merger.times(0)->last(), t0);
}

TEST(DeskewRules, BeamsOfAScannerMountedUpsideDownCountInOrderOfMeasuring) {
  // The same returns, once counted from the right and once from the left, both from right to left in time.
  const PoseTrack track = track_until(80);
  Merger merger(test::full_circle(720, 40), {}, 2, with_visibility());
  PlanarScan upright = sweep_of(541);
  PlanarScan turned = upright;
  turned.set_angles(-upright.angle_min, -upright.angle_increment);
  merger.add(0, upright, Pose::Identity());
  merger.add(1, turned, make_pose({0, 0, 0}, {pi_d, 0, 0}));
  Outputs out;
  merger.merge({t0 + ms(60), &track}, {1, 1}, out.list, &out.cloud);
  ASSERT_EQ(out.cloud.size(), 1082U);
  for (std::size_t i = 0; i < 541; ++i) {
    EXPECT_NEAR(out.cloud.points()[i].x, out.cloud.points()[i + 541].x, 1e-4) << i;
    EXPECT_NEAR(out.cloud.points()[i].y, out.cloud.points()[i + 541].y, 1e-4) << i;
  }
}

TEST(DeskewRules, EchoesOfABeamMoveTogether) {
  const PoseTrack track = track_until(80);
  Merger merger(test::full_circle(720, 40), {}, 1, with_visibility(EchoChoice::all));
  merger.add(0, sweep_of(541, t0, 2), Pose::Identity());  // 5 m and 6 m
  Outputs out;
  merger.merge({t0 + ms(60), &track}, {1}, out.list, &out.cloud);
  ASSERT_EQ(out.cloud.size(), 1082U);
  for (std::size_t i = 0; i < 541; ++i) {
    const CloudPoint& near = out.cloud.points()[i];
    const CloudPoint& far = out.cloud.points()[i + 541];
    EXPECT_NEAR(std::hypot(far.x - near.x, far.y - near.y), 1, 1e-4) << i;
  }
  // The first beam was measured 60 ms and 0.12 m before the instant.
  EXPECT_GT(std::fabs(std::hypot(out.cloud.points()[0].x, out.cloud.points()[0].y) - 5), 0.05);
}

TEST(DeskewRules, VehiclesOwnReturnsStayItsOwnWhileItDrives) {
  // The rear left corner of the vehicle, seen 60 ms and 0.12 m before the instant.
  Merger merger(test::full_circle(720, 40), {}, 1, with_visibility());
  merger.set_footprint(Footprint({{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}));
  PlanarScan scan = sweep_of(541);
  for (std::size_t i = 0; i < scan.beams; ++i) {
    if (i < 4) scan.set_hit(i, 1.38F);
    if (i >= 4) scan.set_without_hit(i, BeamStatus::none);
  }
  merger.add(0, scan, Pose::Identity());
  PoseTrack track;
  for (int t = -100; t <= 80; t += 20) track.add(t0 + ms(t), make_pose({0.002 * t, 0, 0}, {0, 0, 0}));
  Outputs out;
  EXPECT_TRUE(merger.merge({t0 + ms(60), &track}, {1}, out.list, &out.cloud).deskewed);
  EXPECT_LT(out.cloud.points()[0].x, -1.05F);
  for (const PlanarScan* one : {&out.strict, &out.flat})
    EXPECT_EQ(std::count(one->statuses.begin(), one->statuses.end(), BeamStatus::hit), 0);
}

TEST(DeskewRules, NothingIsAllocatedPerMergeInAnyProfileWithOrWithoutMotion) {
  Merger merger(test::full_circle(1440, 40), {}, 2, with_visibility());
  PlanarScan safety;
  Outputs out;
  out.list.push_back({Profile::safety, &safety});
  std::vector<PlanarScan> scans(2, sweep_of(1081));
  PoseTrack track = track_until(80);
  const std::vector<char> use = {1, 1};
  const Pose mounts[] = {make_pose({1, 0.5, 0.3}, {0, 0, 0.3}), make_pose({-1, 0, 0.3}, {0, 0.01, 2})};
  std::uint64_t before = 0;
  for (int round = 0; round < 20; ++round) {
    if (round == 4) before = test::allocations();
    for (std::size_t s = 0; s < 2; ++s) {
      scans[s].stamp = t0 + ms(20 * round + static_cast<int>(s));
      merger.add(s, scans[s], mounts[s]);
    }
    track.add(t0 + ms(100 + 20 * round), make_pose({0.02 * round, 0, 0}, {0, 0, 0.01 * round}));
    merger.merge({t0 + ms(20 * round + 60), round % 2 == 0 ? &track : nullptr}, use, out.list, &out.cloud);
  }
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace lidard
