// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Clouds and profile `flatten` of random mounts, against a search of all returns.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/merge/merger.h"
#include "test/sim/world/rng.h"
#include "test/sim/world/vehicle_motion.h"

namespace lidard {
namespace {

constexpr Stamp start{1'700'000'000'000'000'000};

ScanGrid circle() {
  ScanGridSpec spec;
  spec.beams = 360;
  spec.range_min = 0.5;
  spec.range_max = 15;
  return make_grid(spec).value();
}

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
};

TEST(MergerPoints, EveryReturnIsWhereItIsSeenFromNowWhateverTheMounts) {
  std::size_t points = 0, own = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    sim::Rng rng(seed);
    const sim::SwingingVehicle vehicle(seed, 2);
    PoseTrack track;
    vehicle.report(track, start, 200, 0.5, 1.5);
    const bool moves = seed % 3 != 0;
    const Pose output_from_base = make_pose({rng.within(1), rng.within(1), 0}, {0, 0, rng.within(3)});
    const Footprint body = Footprint({{-2, -1}, {1, -1}, {1, 1}, {-2, 1}}).transformed(output_from_base);
    const Footprint margin = body.padded(Footprint::margin_m);
    const HeightBand band{-0.5, 1.5};
    MergeSettings settings;
    settings.source.veil_filter = false;
    const std::size_t sources = 1 + seed % 3;
    settings.each.assign(sources, settings.source);
    settings.each[0].range_max = 9;
    settings.each[0].angle_min = -1.5;
    Merger merger(circle(), band, sources, settings);
    merger.set_footprint(body);
    std::vector<Expected> expected;
    std::vector<char> use(sources, 1);
    if (sources == 3) use[1] = 0;
    float longest = 0;
    for (std::size_t s = 0; s < sources; ++s) {
      const double begin = 1 + 0.05 * rng.uniform();
      const PlanarScan scan = random_scan(rng, start + span_from_seconds(begin));
      const Pose mount = make_pose({rng.within(2), rng.within(2), rng.uniform()},
                                   {rng.uniform() < 0.5 ? 0 : pi_d, rng.within(0.1), rng.within(3)});
      ASSERT_TRUE(merger.add(s, scan, mount));
      if (use[s] == 0) continue;
      longest = std::max(longest, scan.scan_time);
      for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
        const std::size_t beam = i % scan.beams;
        const double angle = -2 + static_cast<double>(beam) * static_cast<double>(scan.angle_increment);
        if (scan.statuses[i] != BeamStatus::hit) continue;
        const auto range = static_cast<double>(scan.ranges[i]);
        if (s == 0 && (range > 9 || angle < -1.5)) continue;
        const Eigen::Vector3d then =
            mount * Eigen::Vector3d(range * std::cos(angle), range * std::sin(angle), 0);
        Eigen::Vector3d now = then;
        if (moves) {
          const Pose base_now = sim::to_pose(vehicle.at(1.2));
          const Pose base_then = sim::to_pose(vehicle.at(begin + 0.0003 * static_cast<double>(beam)));
          now = output_from_base * (base_now.inverse() * base_then) * (output_from_base.inverse() * then);
        }
        expected.push_back({now, scan.intensities.empty() ? 0 : static_cast<double>(scan.intensities[i]), s});
        // What is the vehicle's own is told by where it was measured.
        if (margin.contains(then.head<2>())) expected.back().source += 100, ++own;
      }
    }
    PlanarScan scan;
    Cloud cloud;
    const MergeMoment moment{start + span_from_seconds(1.2), moves ? &track : nullptr, output_from_base};
    const MergeReport& report = merger.merge(moment, use, {{Profile::flatten, &scan}}, &cloud);
    for (std::size_t s = 0; s < sources; ++s) {
      const SourceUse wanted = use[s] == 0 ? SourceUse::not_used
                               : moves     ? SourceUse::deskewed
                                           : SourceUse::static_poses;
      EXPECT_EQ(report.sources[s], wanted) << seed;
    }
    EXPECT_EQ(report.deskewed, moves);
    EXPECT_EQ(scan.stamp, moment.at);
    EXPECT_EQ(cloud.stamp, moment.at);
    EXPECT_EQ(cloud.end, moment.at);
    EXPECT_EQ(cloud.rings, sources);
    EXPECT_EQ(scan.scan_time, longest);
    ASSERT_EQ(cloud.size(), expected.size()) << seed;
    std::vector<double> nearest(360, 1e9), intensity(360, 0);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const CloudPoint& p = cloud.points()[i];
      const Expected& e = expected[i];
      ASSERT_LT((Eigen::Vector3f(p.x, p.y, p.z).cast<double>() - e.place).norm(), 1e-3) << seed << ' ' << i;
      ASSERT_EQ(static_cast<double>(p.intensity), e.intensity);
      ASSERT_EQ(p.ring, e.source % 100);
      const double range = e.place.head<2>().norm();
      const bool is_own = e.source >= 100 || margin.contains(e.place.head<2>());
      if (is_own || e.place.z() < band.min || e.place.z() > band.max || range < 0.5 || range > 15) continue;
      const std::size_t beam = circle().nearest(std::atan2(e.place.y(), e.place.x()));
      if (range < nearest[beam]) nearest[beam] = range, intensity[beam] = e.intensity;
      ++points;
    }
    int differ = 0;  // a point on the very border of a beam, of the band or of the body may fall either way
    for (std::size_t beam = 0; beam < 360; ++beam) {
      const bool hit = scan.statuses[beam] == BeamStatus::hit;
      const bool same = hit ? std::abs(static_cast<double>(scan.ranges[beam]) - nearest[beam]) < 2e-3 &&
                                  (scan.intensities.empty() ||
                                   static_cast<double>(scan.intensities[beam]) == intensity[beam])
                            : nearest[beam] > 1e8;
      differ += same ? 0 : 1;
    }
    EXPECT_LE(differ, moves ? 4 : 0) << seed;
  }
  EXPECT_GT(points, 2000U);
  EXPECT_GT(own, 100U);
}

TEST(MergerPoints, IntensitiesAreThereWhereAllSourcesInUseHaveThem) {
  const auto has = [](bool first, bool second, const std::vector<char>& use) {
    Merger merger(circle(), {}, 2);
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
