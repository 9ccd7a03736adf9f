// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What virtual scans must say although something is in the way: drops, seams, rings without returns; and what
// they must not say: fronts that no beam can meet.
#include <gtest/gtest.h>

#include "test/core/virtual/cut_bench.h"

namespace lidard::test::cut {
namespace {

/// Puts drops 0.5 to 5.5 m from the lidar into that share of the beams.
Cloud with_drops(const Cloud& clear, const sim::YardLidar& lidar, double share, sim::Rng& rng) {
  Cloud cloud = clear;
  std::vector<CloudPoint> points;
  for (std::size_t c = 0; c < clear.columns.size(); ++c) {
    cloud.columns[c].first_point = static_cast<std::uint32_t>(points.size());
    std::vector<const CloudPoint*> returns(lidar.elevations.size(), nullptr);
    for (std::size_t i = clear.columns[c].first_point; i < clear.points_end(c); ++i)
      returns[clear.points()[i].ring] = &clear.points()[i];
    for (std::size_t ring = 0; ring < returns.size(); ++ring) {
      const CloudPoint* const own = returns[ring];
      const double range =
          own == nullptr
              ? 100
              : std::sqrt(static_cast<double>(own->x * own->x + own->y * own->y + own->z * own->z));
      const double at = 0.5 + 5 * rng.uniform(), e = lidar.elevations[ring];
      const auto azimuth = -static_cast<double>(clear.columns[c].azimuth);
      if (rng.uniform() < share && at < range)
        points.push_back({static_cast<float>(at * std::cos(e) * std::cos(azimuth)),
                          static_cast<float>(at * std::cos(e) * std::sin(azimuth)),
                          static_cast<float>(at * std::sin(e)), 5, static_cast<std::uint16_t>(ring), 0});
      else if (own != nullptr)
        points.push_back(*own);
    }
  }
  cloud.points_bytes.resize(points.size() * sizeof(CloudPoint));
  std::copy(points.begin(), points.end(), cloud.points());
  return cloud;
}

void tell_directions(const sim::YardLidar& lidar, Cloud& cloud) {
  for (const double elevation : lidar.elevations) cloud.directions.push_back({elevation, 0});
}

TEST(UsefulVirtualScan, DropsTakeLittleOfTheFreeSpace) {
  for (const auto& [share, wanted] : {std::pair(0.001, 0.97), {0.005, 0.96}, {0.02, 0.85}}) {
    sim::Rng rng(1);
    std::size_t free = 0, all = 0;
    for (int round = 0; round < 4; ++round) {
      Cloud cloud = seen({}, lidar16());
      tell_directions(lidar16(), cloud);
      Cut cut;
      cut.frame = make_pose({6, 0, plane_height}, {0, 0, 0});
      cut.settings.how.free_required = 12;
      cut.make(with_drops(cloud, lidar16(), share, rng), lidar16().pose);
      for (double deg = -60; deg <= 60; deg += 0.5) {
        ++all;
        free += cut.strict.statuses[cut.grid.nearest(deg * degree)] == BeamStatus::none ? 1 : 0;
      }
    }
    EXPECT_GE(free, static_cast<std::size_t>(wanted * static_cast<double>(all))) << share << " of " << all;
  }
}

TEST(UsefulVirtualScan, RingsThatHaveNotReturnedYetProveWhatTheyPass) {
  // Above the horizon nothing returns, and the plane lies 0.1 m beneath the lidar.
  Cloud cloud = seen({}, lidar16());
  Cut silent, told;
  silent.footprint = told.footprint = Footprint({{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}});
  silent.frame = told.frame = make_pose({0, 0, lidar_height - 0.1}, {0, 0, 0});
  silent.settings.how.free_required = told.settings.how.free_required = 12;
  silent.make(cloud, lidar16().pose);
  EXPECT_EQ(silent.count(silent.strict, BeamStatus::none), 0U) << "nobody knows where they look";
  tell_directions(lidar16(), cloud);
  told.make(cloud, lidar16().pose);
  EXPECT_EQ(told.count(told.strict, BeamStatus::none), told.grid.beams);
}

TEST(UsefulVirtualScan, OfAThingWhoseTopAloneIsMetNothingIsSaidOfItsFront) {
  // The lowest ring meets the top 4.5 m away; the front, 2.9 m away, is in the blind zone.
  for (const double height : {0.7, 0.8, 0.9}) {
    sim::Yard yard;
    yard.objects = {box({5.9, 0, height / 2}, {6, 3, height}), wall(25, -40, 25, 40)};
    Cut cut;
    cut.frame = make_pose({1.1, 0, plane_height}, {0, 0, 0});
    cut.make(seen(yard, lidar16()), lidar16().pose);
    for (double deg = -20; deg <= 20; deg += 0.5) {
      const std::size_t beam = cut.grid.nearest(deg * degree);
      EXPECT_EQ(cut.strict.statuses[beam] == BeamStatus::hit, false) << height << " m, " << deg;
      EXPECT_FALSE(cut.range(cut.safety, deg * degree) > 1.81 / std::cos(deg * degree))
          << height << " m, " << deg;
      EXPECT_NE(cut.safety.statuses[beam], BeamStatus::none);
    }
  }
}

TEST(UsefulVirtualScan, SafetySaysNoRangeOfWhatIsSeenFromItsOtherSideAlone) {
  sim::Yard yard;
  yard.objects = {box({6, 0, 2}, {2, 3, 4}), wall(30, -40, 30, 40)};
  Cut cut;
  cut.frame = make_pose({9, 0, plane_height}, {0, 0, pi_d});  // behind the box, which looks at the lidar
  cut.make(seen(yard, lidar16()), lidar16().pose);
  EXPECT_TRUE(std::isnan(cut.range(cut.strict, 0)));
  EXPECT_FALSE(cut.range(cut.safety, 0) > 2.05) << "it is 2 m away, its seen face 4 m";
}

/// A lidar on a vehicle that turns left about it, two revolutions; the share of silent beams in the second.
double silent_share(double rad_per_s, bool with_revolution_before) {
  constexpr double revolution_s = 0.1;
  sim::Yard yard;
  yard.objects = {wall(15, -15, 15, 15), wall(15, 15, -15, 15), wall(-15, 15, -15, -15),
                  wall(-15, -15, 15, -15)};
  Cut cut;
  Virtualizer virtualizer(cut.grid, {}, 1, cut.settings);
  PlanarScan strict;
  const Pose mount = lidar16().pose;
  Stamp begin{};
  for (int revolution = with_revolution_before ? 0 : 1; revolution < 2; ++revolution) {
    sim::YardLidar lidar = lidar16();
    const double at = revolution * revolution_s;
    lidar.path = [&](Span t) { return make_pose({0, 0, 0}, {0, 0, rad_per_s * (at + seconds(t))}) * mount; };
    Cloud cloud = seen(yard, lidar);
    tell_directions(lidar, cloud);
    if (begin == Stamp{}) begin = cloud.stamp - span_from_seconds(at);
    const Span moved = begin + span_from_seconds(at) - cloud.stamp;
    cloud.stamp = cloud.stamp + moved;
    cloud.end = cloud.end + moved;
    for (CloudColumn& column : cloud.columns) column.stamp = column.stamp + moved;
    PoseTrack track;
    for (int i = -2; i <= 22; ++i)
      track.add(begin + span_from_seconds(0.01 * i), make_pose({0, 0, 0}, {0, 0, rad_per_s * 0.01 * i}));
    CloudMotion motion;
    EXPECT_TRUE(motion.find(cloud, mount, track));
    virtualizer.set_cloud(cloud, mount, &motion);
    virtualizer.project(0, make_pose({1.5, 0, 1.6}, {0, 0, 0}).inverse() * mount,
                        {{Profile::strict, &strict}});
  }
  return static_cast<double>(std::count_if(strict.ranges.begin(), strict.ranges.end(),
                                           [](float r) { return std::isnan(r); })) /
         static_cast<double>(strict.beams);
}

TEST(UsefulVirtualScan, TheWedgeThatATurningVehicleLeavesOpenIsClosedByTheRevolutionBefore) {
  for (const double rad_per_s : {0.8, 2.0}) {
    EXPECT_GT(silent_share(rad_per_s, false), 0.08) << "of one revolution alone";
    EXPECT_LE(silent_share(rad_per_s, true), rad_per_s > 1 ? 0.04 : 0.02) << rad_per_s;
  }
}

}  // namespace
}  // namespace lidard::test::cut
