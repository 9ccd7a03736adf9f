// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/cloud_merger.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "test/support/allocations.h"
#include "test/support/yard.h"

namespace lidard {
namespace {

constexpr double mm = 0.001;
constexpr double speed = 5;     // m/s
constexpr double yaw_rate = 1;  // rad/s
constexpr Stamp start{1'700'000'000'000'000'000};

/// The vehicle's base on its circle; it passes the origin at 0.
Pose driven(Span after) {
  const double turn = yaw_rate * seconds(after);
  const double radius = speed / yaw_rate;
  return make_pose({radius * std::sin(turn), radius * (1 - std::cos(turn)), 0}, {0, 0, turn});
}

/// Odometry of 50 Hz.
PoseTrack odometry(int to_ms = 300) {
  PoseTrack track;
  for (int ms = -100; ms <= to_ms; ms += 20)
    track.add(start + std::chrono::milliseconds(ms), driven(std::chrono::milliseconds(ms)));
  return track;
}

/// Two VLP-16 on a truck's roof, each turned another way; the second one begins its turn 40 ms later.
const std::vector<Pose> mounts{make_pose({0.9, 0.9, 2.1}, {0.02, 0.05, 0.7}),
                               make_pose({-2.5, -0.9, 2.2}, {0, -0.04, -2})};
const std::vector<Span> begins{Span(0), std::chrono::milliseconds(40)};

Cloud seen(const sim::Yard& yard, std::size_t source, bool drives = true) {
  sim::YardLidar lidar;
  lidar.elevations = sim::even_rings(16, -15, 15);
  lidar.columns = 900;
  lidar.path = [=](Span after) {
    return drives ? driven(begins[source] + after) * mounts[source] : mounts[source];
  };
  sim::Rng rng(1);
  Cloud cloud = sim::measure(yard, lidar, rng);
  const Span later = start + begins[source] - cloud.stamp;
  cloud.stamp = cloud.stamp + later;
  cloud.end = cloud.end + later;
  for (CloudColumn& column : cloud.columns) column.stamp = column.stamp + later;
  return cloud;
}

/// A scanner at the front: 541 beams in 20 ms, now and then with two echoes.
PlanarScan sweep(const Pose& mount, Stamp stamp, bool drives) {
  PlanarScan scan;
  scan.frame_id = "front";
  scan.stamp = stamp;
  scan.reset(541, 2);
  scan.set_angles(-2.356F, 4.712F / 540);
  scan.range_max = 40;
  scan.time_increment = 0.02F / 540;
  for (std::size_t beam = 0; beam < scan.beams; ++beam) {
    // A wall 12 m ahead in the world.
    const double angle = static_cast<double>(scan.angle(beam));
    const Span at = stamp - start + span_from_seconds(static_cast<double>(beam) * 0.02 / 540);
    const Pose world = (drives ? driven(at) : Pose::Identity()) * mount;
    const double ahead = (world.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0)).x();
    if (ahead < 0.4) continue;
    scan.set_hit(beam, static_cast<float>((12 - world.translation().x()) / ahead));
    scan.intensities[beam] = static_cast<float>(beam);
    if (beam % 3 == 0) scan.set_hit(scan.index(beam, 1), scan.ranges[beam] + 1);
  }
  return scan;
}

/// Returns by source, ring, ns after the start and number among equal ones; their places in the world.
using Returns = std::map<std::tuple<std::size_t, std::uint16_t, std::int64_t, int>, Eigen::Vector3d>;
void add(Returns& returns, std::size_t source, std::uint16_t ring, double at, const Eigen::Vector3d& place) {
  int number = 0;
  const auto tenth_us = std::llround(at * 1e6);
  while (!returns.emplace(std::tuple(source, ring, tenth_us, number), place).second) ++number;
}
Eigen::Vector3d place_of(const CloudPoint& p) { return Eigen::Vector3f(p.x, p.y, p.z).cast<double>(); }

/// Where the returns of a cloud were in the world when they were measured: the truth.
void add_truth(Returns& returns, std::size_t source, const Cloud& cloud) {
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    const Span at = cloud.columns[c].stamp - start;
    for (std::size_t i = cloud.columns[c].first_point; i < cloud.points_end(c); ++i)
      add(returns, source, cloud.points()[i].ring, seconds(at),
          driven(at) * mounts[source] * place_of(cloud.points()[i]));
  }
}

sim::Yard yard_of(std::uint64_t seed) { return sim::make_yard_scene(sim::yard_cases()[0], seed).yard; }

MergeMoment moment_at(Stamp at, const PoseTrack* track) {
  MergeMoment moment;
  moment.at = at;
  moment.track = track;
  moment.output_from_base = make_pose({-1, 0.2, 0.3}, {0, 0, 0.4});
  return moment;
}

/// Each return of `truth` is in `merged` once, and nothing else is; the greatest distance from its place, m.
double worst_error(const Returns& truth, const MergedCloud& merged, const MergeMoment& moment) {
  const Pose world_from_output = driven(moment.at - start) * moment.output_from_base.inverse();
  Returns found;
  for (std::size_t i = 0; i < merged.size(); ++i) {
    const MergedPoint& p = merged.points()[i];
    if (std::isnan(p.point.x)) continue;
    add(found, p.sensor, p.point.ring, seconds(merged.stamp - start) + static_cast<double>(p.point.time),
        world_from_output * place_of(p.point));
  }
  EXPECT_EQ(found.size(), truth.size());
  double worst = 0;
  for (const auto& [key, place] : truth) {
    const auto one = found.find(key);
    if (one == found.end()) return ADD_FAILURE() << "a return is missing", 1e9;
    worst = std::max(worst, (one->second - place).norm());
  }
  return worst;
}

TEST(CloudMerger, EveryReturnOfEverySourceIsThereOnceAndWhereItWasAtTheInstant) {
  const PoseTrack track = odometry();
  for (const bool organised : {false, true}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const sim::Yard yard = yard_of(seed);
      CloudMerger merger(2, organised);
      Returns truth;
      for (std::size_t s = 0; s < 2; ++s) {
        const Cloud cloud = seen(yard, s);
        add_truth(truth, s, cloud);
        ASSERT_TRUE(merger.add(s, cloud, mounts[s]));
      }
      MergedCloud merged;
      const MergeMoment moment = moment_at(start + std::chrono::milliseconds(139), &track);
      const MergeReport& report = merger.merge(moment, {1, 1}, merged);
      EXPECT_EQ(report.sources, std::vector<SourceUse>(2, SourceUse::deskewed));
      EXPECT_EQ(merged.stamp, moment.at);
      EXPECT_GT(truth.size(), 15'000U);
      EXPECT_LT(worst_error(truth, merged, moment), 1 * mm) << seed;
      // The test must see what is not moved.
      merger.merge(moment_at(moment.at, nullptr), {1, 1}, merged);
      EXPECT_GT(worst_error(truth, merged, moment), 0.3);
    }
  }
}

TEST(CloudMerger, AnOrganisedCloudHasARowPerRingSourceBySource) {
  const sim::Yard yard = yard_of(3);
  CloudMerger merger(3, true);
  const Cloud first = seen(yard, 0, false), second = seen(yard, 1, false);
  const PlanarScan scan = sweep(Pose::Identity(), start, false);
  ASSERT_TRUE(merger.add(0, first, mounts[0]));
  ASSERT_TRUE(merger.add(1, scan, Pose::Identity()));
  ASSERT_TRUE(merger.add(2, second, mounts[1]));
  MergedCloud merged;
  merger.merge(moment_at(start, nullptr), {1, 1, 1}, merged);
  ASSERT_EQ(merged.height, 16U + 1 + 16);
  const std::size_t width = merged.size() / merged.height;
  EXPECT_EQ(width, 541U * 2) << "the scanner has a column per beam and echo";
  for (std::size_t i = 0; i < merged.size(); ++i) {
    const MergedPoint& p = merged.points()[i];
    const std::size_t row = i / width, column = i % width;
    ASSERT_EQ(p.sensor, row < 16 ? 0 : row == 16 ? 1 : 2);
    ASSERT_EQ(p.point.ring, row < 16 ? row : row == 16 ? 0 : row - 17);
    if (p.sensor == 0 && !std::isnan(p.point.x)) {
      ASSERT_LT(column, first.columns.size());
      ASSERT_NEAR(p.point.time, seconds(first.columns[column].stamp - start), 1e-6);
    }
  }
  merger.merge(moment_at(start, nullptr), {0, 0, 1}, merged);
  EXPECT_EQ(merged.height, 16U);
  // A cloud of another driver has no firing sequences.
  Cloud foreign = first;
  foreign.columns.clear();
  foreign.stamp = foreign.stamp + Span(1);
  ASSERT_TRUE(merger.add(0, foreign, mounts[0]));
  merger.merge(moment_at(start, nullptr), {1, 0, 0}, merged);
  EXPECT_EQ(merged.height, 0U);
  EXPECT_EQ(merged.size(), first.size());
}

TEST(CloudMerger, ASweepOfAPlanarScannerIsMovedBeamByBeamWithAllItsEchoes) {
  const PoseTrack track = odometry();
  const Pose mount = make_pose({1, 0, 0.4}, {0, 0, 0.1});
  const PlanarScan scan = sweep(mount, start, true);
  CloudMerger merger(1, false);
  ASSERT_TRUE(merger.add(0, scan, mount));
  MergedCloud merged;
  const MergeMoment moment = moment_at(start + std::chrono::milliseconds(20), &track);
  merger.merge(moment, {1}, merged);
  std::size_t hits = 0, on_wall = 0;
  for (const BeamStatus status : scan.statuses) hits += status == BeamStatus::hit ? 1 : 0;
  ASSERT_EQ(merged.size(), hits);
  const Pose world_from_output = driven(moment.at - start) * moment.output_from_base.inverse();
  for (std::size_t i = 0; i < merged.size(); ++i) {
    const CloudPoint& p = merged.points()[i].point;
    const Eigen::Vector3d at = world_from_output * place_of(p);
    EXPECT_NEAR(at.z(), 0.4, 1 * mm);
    on_wall += std::abs(at.x() - 12) < 1 * mm ? 1 : 0;
  }
  EXPECT_EQ(on_wall, hits - static_cast<std::size_t>(std::count(scan.statuses.begin() + 541,
                                                                scan.statuses.end(), BeamStatus::hit)));
}

TEST(CloudMerger, ASourceThatIsNotUsedIsNotInTheCloud) {
  CloudMerger merger(2, false);
  const sim::Yard yard = yard_of(1);
  const Cloud first = seen(yard, 0, false);
  ASSERT_TRUE(merger.add(0, first, mounts[0]));
  MergedCloud merged;
  merger.merge(moment_at(start, nullptr), {1, 1}, merged);
  EXPECT_EQ(merged.size(), first.size()) << "the second one never came";
  ASSERT_TRUE(merger.add(1, seen(yard, 1, false), mounts[1]));
  EXPECT_EQ(merger.merge(moment_at(start, nullptr), {0, 1}, merged).sources[0], SourceUse::not_used);
  EXPECT_EQ(merger.placed()[0].cloud, nullptr);
  for (std::size_t i = 0; i < merged.size(); ++i) ASSERT_EQ(merged.points()[i].sensor, 1);
  merger.merge(moment_at(start, nullptr), {0, 0}, merged);
  EXPECT_EQ(merged.size(), 0U);
}

TEST(CloudMerger, CloudsThatAreNotNewerAreCountedAndAnInputMayStartAgain) {
  CloudMerger merger(1, false);
  Cloud cloud = seen(yard_of(1), 0, false);
  EXPECT_TRUE(merger.add(0, cloud, mounts[0]));
  EXPECT_FALSE(merger.add(0, cloud, mounts[0]));
  EXPECT_EQ(merger.out_of_order(), 1U);
  cloud.stamp = cloud.stamp + std::chrono::milliseconds(100);
  EXPECT_TRUE(merger.add(0, cloud, mounts[0]));
  EXPECT_EQ(merger.superseded(), 1U);
  cloud.stamp = cloud.stamp - std::chrono::seconds(5);
  EXPECT_TRUE(merger.add(0, cloud, mounts[0]));
  PlanarScan scan = sweep(Pose::Identity(), start + std::chrono::seconds(1), false);
  scan.time_increment = -1;
  EXPECT_FALSE(merger.add(0, scan, Pose::Identity()));
}

TEST(CloudMerger, WithoutPosesASourceStandsWhereItWasMeasured) {
  CloudMerger merger(2, false);
  const sim::Yard yard = yard_of(2);
  for (std::size_t s = 0; s < 2; ++s) merger.add(s, seen(yard, s), mounts[s]);
  // The newest pose is too old for the second one, which goes on 40 ms longer.
  const PoseTrack track = odometry(60);
  MergedCloud merged;
  const MergeReport& report =
      merger.merge(moment_at(start + std::chrono::milliseconds(60), &track), {1, 1}, merged);
  EXPECT_EQ(report.sources[0], SourceUse::extrapolated);
  EXPECT_EQ(report.sources[1], SourceUse::static_poses);
  EXPECT_EQ(merger.placed()[1].motion, nullptr);
}

TEST(CloudMerger, NothingIsAllocatedPerCloudAfterWarmUp) {
  const PoseTrack track = odometry();
  const sim::Yard yard = yard_of(4);
  Cloud clouds[] = {seen(yard, 0), seen(yard, 1)};
  PlanarScan scan = sweep(Pose::Identity(), start, true);
  CloudMerger merger(3, true);
  MergedCloud merged;
  const MergeMoment moment = moment_at(start + std::chrono::milliseconds(139), &track);
  const std::vector<char> use(3, 1);
  const auto turn = [&] {
    for (std::size_t s = 0; s < 2; ++s) {
      clouds[s].stamp = clouds[s].stamp + Span(1);
      merger.add(s, clouds[s], mounts[s]);
    }
    scan.stamp = scan.stamp + Span(1);
    merger.add(2, scan, Pose::Identity());
    merger.merge(moment, use, merged);
  };
  turn();
  const std::size_t before = test::allocations();
  for (int i = 0; i < 5; ++i) turn();
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace lidard
