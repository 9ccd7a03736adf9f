// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Clouds and profile `flatten` of random mounts, against a search of all returns.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/merge/merger.h"
#include "test/sim/world/circle.h"
#include "test/sim/world/rng.h"
#include "test/sim/world/vehicle_motion.h"

namespace lidard {
namespace {

constexpr Stamp start{1'700'000'000'000'000'000};

PlanarScan random_scan(sim::Rng& rng, Stamp stamp) {
  PlanarScan scan;
  scan.reset(200, rng.uniform() < 0.3 ? 2 : 1, rng.uniform() < 0.7);
  scan.set_angles(-2, rng.uniform() < 0.5 ? 0.02F : -0.013F);
  scan.range_max = 30;
  scan.stamp = stamp;
  scan.time_increment = 0.0003F;
  scan.scan_time = static_cast<float>(0.05 + 0.05 * rng.uniform());
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (!scan.intensities.empty()) scan.intensities[i] = static_cast<float>(std::floor(200 * rng.uniform()));
    if (rng.uniform() < 0.7) scan.set_hit(i, static_cast<float>(0.3 + 18 * rng.uniform()));
  }
  return scan;
}

struct Expected {
  Eigen::Vector3d place;
  double intensity;
  std::size_t source;
  bool own;  ///< by where it was measured
};

/// A merge of random mounts, and where each return must be seen from now.
struct RandomMerge {
  explicit RandomMerge(std::uint64_t a_seed) : seed(a_seed), rng(seed), vehicle(seed, 2) {
    vehicle.report(track, start, 200, 0.5, 1.5);
    output_from_base = make_pose({rng.within(1), rng.within(1), 0}, {0, 0, rng.within(3)});
    const Footprint body = Footprint({{-2, -1}, {1, -1}, {1, 1}, {-2, 1}}).transformed(output_from_base);
    margin = body.padded(Footprint::margin_m);
    MergeSettings settings;
    settings.source.veil_filter = false;
    const std::size_t sources = 1 + seed % 3;
    settings.each.assign(sources, settings.source);
    settings.each[0].range_max = 9;
    settings.each[0].angle_min = -1.5;
    Merger merger(test::full_circle(360, 15, 0.5), band, sources, settings);
    merger.set_footprint(body);
    use.assign(sources, 1);
    if (sources == 3) use[1] = 0;
    for (std::size_t s = 0; s < sources; ++s) add(s, merger);
    report = merger.merge({now, moves ? &track : nullptr, output_from_base}, use, {{Profile::flatten, &scan}},
                          &cloud);
  }

  void add(std::size_t s, Merger& merger) {
    const double begin = 1 + 0.05 * rng.uniform();
    const PlanarScan measured = random_scan(rng, start + span_from_seconds(begin));
    const Pose mount = make_pose({rng.within(2), rng.within(2), rng.uniform()},
                                 {rng.uniform() < 0.5 ? 0 : pi_d, rng.within(0.1), rng.within(3)});
    ASSERT_TRUE(merger.add(s, measured, mount));
    if (use[s] == 0) return;
    longest = std::max(longest, measured.scan_time);
    for (std::size_t i = 0; i < measured.ranges.size(); ++i) {
      const std::size_t beam = i % measured.beams;
      const double angle = -2 + static_cast<double>(beam) * static_cast<double>(measured.angle_increment);
      const auto range = static_cast<double>(measured.ranges[i]);
      if (measured.statuses[i] != BeamStatus::hit || (s == 0 && (range > 9 || angle < -1.5))) continue;
      const Eigen::Vector3d then =
          mount * Eigen::Vector3d(range * std::cos(angle), range * std::sin(angle), 0);
      const Pose base_then = sim::to_pose(vehicle.at(begin + 0.0003 * static_cast<double>(beam)));
      const Pose way = sim::to_pose(vehicle.at(1.2)).inverse() * base_then;
      expected.push_back({moves ? output_from_base * (way * (output_from_base.inverse() * then)) : then,
                          measured.intensities.empty() ? 0 : static_cast<double>(measured.intensities[i]), s,
                          margin.contains(then.head<2>())});
    }
  }

  std::uint64_t seed;
  sim::Rng rng;
  sim::SwingingVehicle vehicle;
  PoseTrack track;
  bool moves = seed % 3 != 0;
  Stamp now = start + span_from_seconds(1.2);
  Pose output_from_base;
  Footprint margin;
  HeightBand band{-0.5, 1.5};
  std::vector<char> use;
  std::vector<Expected> expected;
  float longest = 0;
  MergeReport report;
  PlanarScan scan;
  Cloud cloud;
};

TEST(MergerPoints, EveryReturnIsWhereItIsSeenFromNowWhateverTheMounts) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const RandomMerge merge(seed);
    for (std::size_t s = 0; s < merge.use.size(); ++s) {
      const SourceUse used = merge.moves ? SourceUse::deskewed : SourceUse::static_poses;
      EXPECT_EQ(merge.report.sources[s], merge.use[s] == 0 ? SourceUse::not_used : used) << seed;
    }
    EXPECT_EQ(merge.report.deskewed, merge.moves);
    EXPECT_EQ(merge.scan.stamp, merge.now);
    EXPECT_EQ(merge.cloud.stamp, merge.now);
    EXPECT_EQ(merge.cloud.end, merge.now);
    EXPECT_EQ(merge.cloud.rings, merge.use.size());
    EXPECT_EQ(merge.scan.scan_time, merge.longest);
    ASSERT_EQ(merge.cloud.size(), merge.expected.size()) << seed;
    for (std::size_t i = 0; i < merge.expected.size(); ++i) {
      const CloudPoint& p = merge.cloud.points()[i];
      const Expected& e = merge.expected[i];
      ASSERT_LT((Eigen::Vector3f(p.x, p.y, p.z).cast<double>() - e.place).norm(), 1e-3) << seed << ' ' << i;
      ASSERT_EQ(static_cast<double>(p.intensity), e.intensity);
      ASSERT_EQ(p.ring, e.source);
    }
  }
}

TEST(MergerPoints, OfTheReturnsInABeamTheNearestCountsThatIsInTheBandAndNotTheVehicle) {
  std::size_t points = 0, own = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const RandomMerge merge(seed);
    std::vector<double> nearest(360, 1e9), intensity(360, 0);
    for (const Expected& e : merge.expected) {
      const double range = e.place.head<2>().norm();
      own += e.own ? 1 : 0;
      if (e.own || merge.margin.contains(e.place.head<2>()) || range < 0.5 || range > 15) continue;
      if (e.place.z() < merge.band.min || e.place.z() > merge.band.max) continue;
      const std::size_t beam = test::full_circle(360, 15, 0.5).nearest(std::atan2(e.place.y(), e.place.x()));
      if (range < nearest[beam]) nearest[beam] = range, intensity[beam] = e.intensity;
      ++points;
    }
    int differ = 0;  // a point on the very border of a beam, of the band or of the body may fall either way
    for (std::size_t beam = 0; beam < 360; ++beam) {
      const bool hit = merge.scan.statuses[beam] == BeamStatus::hit;
      const bool same = hit ? std::abs(static_cast<double>(merge.scan.ranges[beam]) - nearest[beam]) < 2e-3 &&
                                  (merge.scan.intensities.empty() ||
                                   static_cast<double>(merge.scan.intensities[beam]) == intensity[beam])
                            : nearest[beam] > 1e8;
      differ += same ? 0 : 1;
    }
    EXPECT_LE(differ, merge.moves ? 4 : 0) << seed;
  }
  EXPECT_GT(points, 2000U);
  EXPECT_GT(own, 100U);
}

TEST(MergerPoints, IntensitiesAreThereWhereAllSourcesInUseHaveThem) {
  const auto has = [](bool first, bool second, const std::vector<char>& use) {
    Merger merger(test::full_circle(360, 15, 0.5), {}, 2);
    for (std::size_t s = 0; s < 2; ++s) {
      PlanarScan scan;
      scan.reset(10, 1, s == 0 ? first : second);
      scan.set_angles(0, 0.1F);
      scan.range_max = 30;
      scan.stamp = start;
      merger.add(s, scan, Pose::Identity());
    }
    PlanarScan out;
    merger.merge({start}, use, {{Profile::flatten, &out}}, nullptr);
    return !out.intensities.empty();
  };
  EXPECT_TRUE(has(true, true, {1, 1}));
  EXPECT_FALSE(has(true, false, {1, 1}));
  EXPECT_FALSE(has(false, true, {1, 1}));
  EXPECT_TRUE(has(true, false, {1, 0})) << "who is not used does not matter";
}

}  // namespace
}  // namespace lidard
