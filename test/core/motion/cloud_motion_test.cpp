// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "core/motion/frame_motion.h"
#include "test/core/virtual/cut_bench.h"
#include "test/support/allocations.h"

namespace lidard {
namespace {

using namespace test::cut;

constexpr double speed = 2.2;      // m/s
constexpr double yaw_rate = -1.2;  // rad/s; with the lidar, so that no sector stays unseen
constexpr double wall_ahead = 8;   // m, in the world
constexpr double mm = 0.001;

/// The lidar on the vehicle's roof, not over its origin.
Pose mount() { return make_pose({0.7, -0.2, lidar_height}, {0, 0, 0.3}); }

/// The vehicle's base on its circle; it passes the origin at 0.
Pose driven(Span after) {
  const double turn = yaw_rate * seconds(after);
  const double radius = speed / yaw_rate;
  return make_pose({radius * std::sin(turn), radius * (1 - std::cos(turn)), 0}, {0, 0, turn});
}

/// A revolution of 0.1 s in a room of two walls, on the way.
Cloud seen_while_driving() {
  sim::Yard yard;
  yard.objects = {wall(wall_ahead, -60, wall_ahead, 60), wall(-11, -60, -11, 60)};
  sim::YardLidar lidar = lidar16();
  lidar.path = [](Span after) { return driven(after) * mount(); };
  return seen(yard, lidar);
}

/// As a topic without columns has it.
Cloud without_columns(Cloud cloud) {
  cloud.columns.clear();
  return cloud;
}

/// Odometry of 50 Hz from `from` to `to` ms after the cloud's stamp.
PoseTrack odometry(const Cloud& cloud, int from_ms, int to_ms) {
  PoseTrack track;
  for (int ms = from_ms; ms <= to_ms; ms += 20) {
    const Span after = std::chrono::milliseconds(ms);
    track.add(cloud.stamp + after, driven(after));
  }
  return track;
}

Eigen::Vector3d place_of(const CloudPoint& p) {
  return {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)};
}

/// The greatest distance of returns from the walls and the ground where these are at `instant`, m.
double worst_error(const Cloud& cloud, const std::vector<Pose>& columns, Stamp instant) {
  const Pose world_from_cloud = driven(instant - cloud.stamp) * mount();
  double worst = 0;
  std::size_t column = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    while (column + 1 < cloud.columns.size() && cloud.columns[column + 1].first_point <= i) ++column;
    Eigen::Vector3d p = place_of(cloud.points()[i]);
    if (!columns.empty()) p = columns[column] * p;
    p = world_from_cloud * p;
    const double off = std::min({std::abs(p.x() - wall_ahead), std::abs(p.x() + 11), std::abs(p.z())});
    worst = std::max(worst, off);
  }
  return worst;
}

/// The cloud with its points where they are at the instant.
Cloud moved(const CloudMotion& motion, Cloud cloud) {
  move_points(motion, Pose::Identity(), cloud);
  return cloud;
}

TEST(CloudMotion, AWallStaysAWallWhileTheVehicleDrivesAndTurns) {
  const Cloud cloud = seen_while_driving();
  CloudMotion motion;
  ASSERT_TRUE(motion.find(cloud, mount(), odometry(cloud, -60, 140)));
  EXPECT_EQ(motion.instant(), cloud.end);
  ASSERT_EQ(motion.columns().size(), cloud.columns.size());
  EXPECT_LT(worst_error(cloud, motion.columns(), motion.instant()), 1 * mm);
  // What it was like before: the test must see a cloud that is not moved.
  EXPECT_GT(worst_error(cloud, {}, motion.instant()), 0.5);
}

TEST(CloudMotion, TheInstantMayBeAnyOfTheCloud) {
  for (const Cloud& cloud : {seen_while_driving(), without_columns(seen_while_driving())}) {
    for (const int ms : {0, 37, 100}) {
      const Stamp instant = cloud.stamp + std::chrono::milliseconds(ms);
      CloudMotion motion;
      ASSERT_TRUE(motion.find(cloud, mount(), odometry(cloud, -60, 140), instant));
      EXPECT_EQ(motion.instant(), instant);
      EXPECT_LT(worst_error(moved(motion, cloud), {}, instant), 1 * mm) << ms;
    }
  }
  const Cloud cloud = seen_while_driving();
  CloudMotion motion;
  const Stamp begin = cloud.stamp - std::chrono::milliseconds(100);
  EXPECT_FALSE(motion.find(cloud, mount(), odometry(cloud, -60, 140), begin)) << "its pose is not known";
}

TEST(CloudMotion, PointsAreMovedToAnotherFrameAsTheyAreOnAStandingVehicle) {
  Cloud cloud = seen_while_driving();
  const Cloud before = cloud;
  move_points(CloudMotion(), make_pose({1, 2, 3}, {0, 0, 1.5707963267948966}), cloud);
  ASSERT_EQ(cloud.size(), before.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint now = cloud.points()[i], was = before.points()[i];
    ASSERT_NEAR(now.x, 1 - was.y, 1e-5);
    ASSERT_NEAR(now.y, 2 + was.x, 1e-5);
    ASSERT_NEAR(now.z, 3 + was.z, 1e-5);
    ASSERT_TRUE(now.time == was.time && now.ring == was.ring && now.intensity == was.intensity);
  }
}

TEST(CloudMotion, BetweenItsBordersAPointTenMetresAwayIsTwoMicrometresOffAtMost) {
  constexpr double rate = 1.2;  // rad/s
  for (const int length_us : {1000, 1900, 2950, 100'000}) {
    Cloud cloud;
    cloud.end = cloud.stamp + std::chrono::microseconds(length_us);
    PoseTrack track;
    for (int ms = -20; ms <= 120; ms += 20)
      track.add(cloud.stamp + std::chrono::milliseconds(ms), make_pose({0, 0, 0}, {0, 0, rate * ms * 1e-3}));
    CloudMotion motion;
    ASSERT_TRUE(motion.find(cloud, Pose::Identity(), track));
    for (double share = 0; share <= 1; share += 0.0137) {
      const double after = share * length_us * 1e-6;
      const double turn = rate * (after - length_us * 1e-6);
      const Eigen::Vector3d truth(10 * std::cos(turn), 10 * std::sin(turn), 0);
      EXPECT_LT((motion.at(after) * Eigen::Vector3d(10, 0, 0) - truth).norm(), 2e-6)
          << length_us << ' ' << share;
    }
  }
}

TEST(CloudMotion, TheInstantIsNotLaterThanTheNewestPose) {
  const Cloud cloud = seen_while_driving();
  CloudMotion motion;
  ASSERT_TRUE(motion.find(cloud, mount(), odometry(cloud, -60, 60)));
  EXPECT_EQ(motion.instant(), cloud.stamp + std::chrono::milliseconds(60));
  EXPECT_LT(worst_error(cloud, motion.columns(), motion.instant()), 5 * mm)
      << "returns after the newest pose are moved by the motion carried on";
  EXPECT_FALSE(motion.find(cloud, mount(), odometry(cloud, -60, 40))) << "60 ms are too long to guess";
}

TEST(CloudMotion, AStandingVehicleLeavesEveryReturnWhereItIs) {
  const Cloud cloud = without_columns(seen_while_driving());
  PoseTrack track;
  const Pose parked = make_pose({3, -7, 0}, {0, 0, 2});
  for (int ms = -20; ms <= 120; ms += 20) track.add(cloud.stamp + std::chrono::milliseconds(ms), parked);
  CloudMotion motion;
  ASSERT_TRUE(motion.find(cloud, mount(), track));
  EXPECT_TRUE(motion.stands());
  EXPECT_EQ(motion.at(0.03).matrix(), Pose::Identity().matrix());
}

TEST(CloudMotion, WithoutPosesForAllOfTheCloudItIsNotMoved) {
  const Cloud cloud = seen_while_driving();
  CloudMotion motion;
  ASSERT_TRUE(motion.find(cloud, mount(), odometry(cloud, -60, 140)));
  EXPECT_FALSE(motion.find(cloud, mount(), PoseTrack())) << "no poses at all";
  EXPECT_TRUE(motion.columns().empty()) << "no motion of an earlier cloud is left";
  EXPECT_FALSE(motion.find(cloud, mount(), odometry(cloud, 20, 140))) << "its begin lacks a pose";
  EXPECT_FALSE(motion.find(cloud, mount(), odometry(cloud, -400, -60))) << "the poses stopped before it";
  PoseTrack torn;
  for (const int ms : {-20, 0, 280, 300}) {
    const Span after = std::chrono::milliseconds(ms);
    torn.add(cloud.stamp + after, driven(after));
  }
  EXPECT_FALSE(motion.find(cloud, mount(), torn)) << "0.28 s between two poses";
}

TEST(CloudMotion, ThePoseOfOneInstantTellsNoMotion) {
  Cloud cloud = seen_while_driving();
  PoseTrack track;
  track.add(cloud.stamp, driven(Span(0)));
  CloudMotion motion;
  EXPECT_FALSE(motion.find(cloud, mount(), track));
  // A cloud of that very instant needs no motion.
  cloud.end = cloud.stamp;
  for (CloudColumn& column : cloud.columns) column.stamp = cloud.stamp;
  ASSERT_TRUE(motion.find(cloud, mount(), track));
  EXPECT_EQ(motion.instant(), cloud.stamp);
  for (const Pose& column : motion.columns()) EXPECT_TRUE(column.isApprox(Pose::Identity(), 1e-12));
}

TEST(CloudMotion, AnEmptyCloudMovesWithoutHarm) {
  Cloud cloud = seen_while_driving();
  const PoseTrack track = odometry(cloud, -60, 140);
  cloud.clear();
  CloudMotion motion;
  EXPECT_TRUE(motion.find(cloud, mount(), track));
  EXPECT_TRUE(motion.columns().empty());
}

TEST(CloudMotion, TimesOutsideOfTheCloudGetThePoseOfItsEnds) {
  // Those of other drivers' points may lie outside of what stamp and end promise.
  const Cloud cloud = seen_while_driving();
  CloudMotion motion;
  ASSERT_TRUE(motion.find(cloud, mount(), odometry(cloud, -60, 140)));
  const double length = seconds(cloud.end - cloud.stamp);
  EXPECT_TRUE(motion.at(length).isApprox(Pose::Identity(), 1e-9));
  EXPECT_EQ(motion.at(1e9).matrix(), motion.at(length).matrix());
  EXPECT_EQ(motion.at(-1).matrix(), motion.at(0).matrix());
  EXPECT_EQ(motion.at(NAN).matrix(), motion.at(0).matrix());
  EXPECT_GT(motion.at(0).translation().norm(), 0.15);
}

TEST(CloudMotion, NothingIsAllocatedPerCloudAfterWarmUp) {
  const Cloud cloud = seen_while_driving();
  const Cloud topic = without_columns(cloud);
  const PoseTrack track = odometry(cloud, -60, 140);
  CloudMotion motion;
  Cloud copies[] = {cloud, topic};
  const auto once = [&] {
    for (Cloud& one : copies) {
      ASSERT_TRUE(motion.find(one, mount(), track));
      move_points(motion, mount(), one);
    }
  };
  once();
  const std::uint64_t before = test::allocations();
  once();
  EXPECT_EQ(test::allocations() - before, 0U);
}

/// Beams that meet a wall at the instant that the scan shows must say so; `most_silent` of them may say
/// nothing.
void expect_walls(const Cut& cut, const PlanarScan& scan, const Pose& virtual_in_world, double most_silent) {
  std::size_t all = 0;
  std::size_t silent = 0;
  for (std::size_t beam = 0; beam < scan.beams; ++beam) {
    const double angle = cut.grid.angle(beam);
    const Eigen::Vector3d way =
        virtual_in_world.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
    const double x = virtual_in_world.translation().x();
    const double truth = ((way.x() > 0 ? wall_ahead : -11) - x) / way.x();
    if (truth > 14) continue;
    ++all;
    silent += scan.statuses[beam] == BeamStatus::invalid ? 1 : 0;
    if (scan.statuses[beam] == BeamStatus::invalid) continue;
    ASSERT_EQ(scan.statuses[beam], BeamStatus::hit) << angle / degree << " deg, " << truth;
    EXPECT_NEAR(static_cast<double>(scan.ranges[beam]), truth, 0.010) << angle / degree;
  }
  EXPECT_GT(all, 300U);
  EXPECT_LE(static_cast<double>(silent), most_silent * static_cast<double>(all)) << "of " << all;
}

// Where begin and end of a turn meet, a return of one may stand in the way of the other one's beam.
constexpr double where_turns_meet = 0.003;

/// Virtual scans of a cloud measured while driving, at the instant of its end.
struct DrivenCut : Cut {
  Stamp instant;
  void drive(const Cloud& cloud) {
    CloudMotion motion;
    const PoseTrack track = odometry(cloud, -60, 140);
    EXPECT_TRUE(motion.find(cloud, mount(), track));
    instant = motion.instant();
    Virtualizer virtualizer(grid, band, 1, settings);
    virtualizer.set_cloud(cloud, mount(), &motion);
    virtualizer.project(0, frame.inverse() * mount(),
                        {{Profile::strict, &strict}, {Profile::safety, &safety}});
  }
  Pose in_world(const Cloud& cloud) const { return driven(instant - cloud.stamp) * frame; }
};

TEST(CloudMotion, VirtualScansShowTheWallsAtTheirInstant) {
  const Cloud cloud = seen_while_driving();
  const Cloud topic = without_columns(cloud);
  DrivenCut cut;
  cut.drive(cloud);
  expect_walls(cut, cut.safety, cut.in_world(cloud), where_turns_meet);
  expect_walls(cut, cut.strict, cut.in_world(cloud), where_turns_meet);
  cut.drive(topic);
  expect_walls(cut, cut.safety, cut.in_world(topic), where_turns_meet);
  expect_walls(cut, cut.strict, cut.in_world(topic), where_turns_meet);
  // Without rings: these are where the beams were when they measured, not where their returns are now.
  Cloud bare = topic;
  for (std::size_t i = 0; i < bare.size(); ++i) bare.points()[i].ring = 0;
  bare.rings = 1;
  cut.drive(bare);
  expect_walls(cut, cut.safety, cut.in_world(bare), where_turns_meet);
}

/// A device that fires its planes one after the other: columns that go round several times.
TEST(CloudMotion, AScannerOfOnePlaneAfterTheOtherIsMovedToo) {
  const Cloud turned = seen_while_driving();
  Cloud cloud = turned;
  cloud.columns.clear();
  cloud.points_bytes.clear();
  for (std::uint16_t ring = 0; ring < turned.rings; ++ring) {
    for (std::size_t c = 0; c < turned.columns.size(); ++c) {
      CloudColumn column = turned.columns[c];
      const std::size_t end =
          c + 1 < turned.columns.size() ? turned.columns[c + 1].first_point : turned.size();
      std::size_t point = column.first_point;
      while (point < end && turned.points()[point].ring != ring) ++point;
      column.first_point = static_cast<std::uint32_t>(cloud.size());
      cloud.columns.push_back(column);
      if (point == end) continue;
      const auto* bytes = turned.points_bytes.data() + point * sizeof(CloudPoint);
      cloud.points_bytes.insert(cloud.points_bytes.end(), bytes, bytes + sizeof(CloudPoint));
    }
  }
  DrivenCut cut;
  cut.drive(cloud);
  expect_walls(cut, cut.safety, cut.in_world(cloud), where_turns_meet);
  expect_walls(cut, cut.strict, cut.in_world(cloud), where_turns_meet);
}

TEST(CloudMotion, TheVehiclesOwnReturnsGoWithIt) {
  // A pillar on the vehicle, 0.1 m inside its outline's margin: moved back to where it was 0.1 s ago it would
  // stand outside.
  Cloud cloud = without_columns(seen_while_driving());
  for (std::size_t i = 0; i < cloud.size(); i += 40) {
    CloudPoint& p = cloud.points()[i];
    const Eigen::Vector3d at = mount().inverse() * Eigen::Vector3d(-1.95, 0.9, plane_height);
    p.x = static_cast<float>(at.x()), p.y = static_cast<float>(at.y()), p.z = static_cast<float>(at.z());
  }
  CloudMotion motion;
  ASSERT_TRUE(motion.find(cloud, mount(), odometry(cloud, -60, 140)));
  Virtualizer virtualizer(full_circle(720), {-0.1, 0.1}, 1);
  virtualizer.set_footprint(Footprint({{-2, -1}, {1, -1}, {1, 1}, {-2, 1}}));
  virtualizer.set_cloud(cloud, mount(), &motion);
  PlanarScan flat;
  virtualizer.project(0, make_pose({0, 0, plane_height}, {0, 0, 0}).inverse() * mount(),
                      {{Profile::flatten, &flat}});
  std::size_t hits = 0;
  for (std::size_t beam = 0; beam < flat.beams; ++beam) {
    if (flat.statuses[beam] != BeamStatus::hit) continue;
    ++hits;
    EXPECT_GT(flat.ranges[beam], 4.0F) << beam;
  }
  EXPECT_GT(hits, 0U);
}

}  // namespace
}  // namespace lidard
