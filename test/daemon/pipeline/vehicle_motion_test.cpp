// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/vehicle_motion.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "daemon/health/output_health.h"
#include "test/support/pipeline_bench.h"
#include "test/support/says.h"

namespace lidard {
namespace {

using test::bench_begin;
using test::PipelineBench;
using test::round_scan;
using testing::HasSubstr;

/// A vehicle that has told poses of [0, newest pose] and data stamped `data`; all of it came in at time 0.
struct Watched {
  Watched() { vehicle.odometry_topic = "/odom"; }
  Watched(double newest_pose, double data) : Watched(0, newest_pose, data) {}
  Watched(double oldest_pose, double newest_pose, double data) : Watched() {
    tell_pose(oldest_pose, 0);
    if (newest_pose > oldest_pose) tell_pose(newest_pose, 0);
    motion.note_data(bench_begin + ms(data), bench_begin);
  }
  void tell_pose(double at, double arrival, const std::string& child = "") {
    motion.add_pose(bench_begin + ms(at), Pose::Identity(), child, bench_begin + ms(arrival));
  }
  /// What is wrong; empty: nothing.
  std::string after(double passed) const {
    const DiagnosticItem item = motion_health(motion.status(bench_begin + ms(passed)).value());
    EXPECT_EQ(item.health, item.message == "poses come in" ? Health::ok : Health::warn);
    return item.health == Health::ok ? "" : item.message;
  }
  VehicleConfig vehicle;
  test::KnownTransforms tf;
  FrameTree frames{"base_link", {}, tf};
  VehicleMotion motion{vehicle, tf, frames};
};

const std::string any_more = text<says::no_pose_any_more>();

TEST(VehicleMotion, PosesMayLagTheDataByHalfASecond) {
  EXPECT_EQ(Watched(1000, 1500).after(0), "");
  EXPECT_EQ(Watched(1000, 1501).after(0),
            "the newest pose of the vehicle is 0.5 s older than the newest scan, which is not deskewed; does "
            "odometry still come, and are its stamps of the same clock?");
  EXPECT_THAT(Watched(1000, 3000).after(0), HasSubstr("is 2.0 s older"));
}

TEST(VehicleMotion, PosesMayBeginHalfASecondAfterTheData) {
  EXPECT_EQ(Watched(1500, 2000, 1000).after(0), "");
  EXPECT_EQ(Watched(1501, 2000, 1000).after(0),
            "the oldest pose of the vehicle is 0.5 s newer than the newest scan, which is not deskewed; are "
            "the stamps of both of the same clock?");
}

TEST(VehicleMotion, WithoutDataForASecondThePosesAloneAreLookedAt) {
  Watched lagging(1000, 3000);
  EXPECT_THAT(lagging.after(999), HasSubstr("older than the newest scan"));
  EXPECT_EQ(lagging.after(1000), any_more);
  Watched live(1000, 3000);
  live.tell_pose(1100, 1000);
  EXPECT_EQ(live.after(1000), "");
  EXPECT_EQ(live.after(1499), "");
  EXPECT_EQ(live.after(1500), any_more);
}

TEST(VehicleMotion, APoseThatIsToldTwiceIsNoNewOne) {
  Watched live(1000, 3000);
  live.tell_pose(1000, 1400);
  EXPECT_EQ(live.after(1400), any_more) << "it is still that of the begin";
}

TEST(VehicleMotion, ShowsItsCountersAndTheLag) {
  Watched watched(1000, 1250);
  watched.tell_pose(1010, 0);
  DiagnosticItem item = motion_health(watched.motion.status(bench_begin).value());
  EXPECT_EQ(item.name, "motion");
  EXPECT_EQ(item.health, Health::ok);
  EXPECT_EQ(item.message, "poses come in");
  EXPECT_EQ(test::value_of(item, "Knots"), "3");
  EXPECT_EQ(test::value_of(item, "Frame not known"), "0");
  EXPECT_NEAR(std::stod(test::value_of(item, "Scans ahead of poses (s)")), 0.24, 1e-6);
  Watched placeless;
  for (const double at : {0, 10, 20}) placeless.tell_pose(at, at, "gnss");
  item = motion_health(placeless.motion.status(bench_begin).value());
  EXPECT_EQ(item.health, Health::warn);
  EXPECT_EQ(item.message,
            "no pose of the vehicle yet, so scans are not deskewed; see that odometry is published: no tf "
            "from gnss to base_link");
  EXPECT_EQ(test::value_of(item, "Frame not known"), "3");
  EXPECT_EQ(test::value_of(item, "Scans ahead of poses (s)"), "no such key");
}

/// A merged scan of one sweep of 100 ms while the vehicle turns at `yaw_rate` and drives at 2 m/s; the motion
/// comes from turn rates that `imu` measures, a frame whose pose on the vehicle is `mount`.
PlanarScan deskewed_by_imu(const Pose& mount, const std::string& imu, double yaw_rate) {
  PipelineBench bench(
      "vehicle: {imu_topic: /imu, speed_topic: /speed}\n"
      "sensors: {a: {topic: /a, pose: {xyz: [1, 0, 0]}}}\n"
      "merged_scans: {m: {laserscan_topics: a, beams: 720, range_max: 20}}\n");
  bench.tf.set("base_link", "imu", mount);
  bench.pipeline.speed_message(2, bench_begin);
  const Eigen::Vector3d in_base(0, 0, yaw_rate);
  const Eigen::Vector3d measured = imu.empty() ? in_base : mount.linear().transpose() * in_base;
  for (int at = 0; at <= 410; at += 10)
    bench.pipeline.turn_message(bench_begin + ms(at), measured, imu, bench_begin + ms(at));
  bench.give("a", round_scan("a", bench_begin + ms(300), 5, 721, ms(100)), bench_begin + ms(410));
  EXPECT_EQ(bench.value("motion", "Frame not known", bench_begin + ms(400)), "0");
  EXPECT_EQ(bench.value("merged m", "Motion", bench_begin + ms(400)), "deskewed");
  return bench.sink.scans["m"].at(0);
}

TEST(MotionOfAnImu, IsTheVehiclesHoweverTheImuIsTurned) {
  const PlanarScan level = deskewed_by_imu(Pose::Identity(), "", 1.2);
  const PlanarScan still = deskewed_by_imu(Pose::Identity(), "", 0);
  std::size_t differs = 0;
  for (std::size_t i = 0; i < level.beams; ++i)
    differs += std::abs(level.ranges[i] - still.ranges[i]) > 0.02F ? 1 : 0;
  ASSERT_GT(differs, level.beams / 4) << "the motion must show";
  std::mt19937 random(5);
  std::uniform_real_distribution<double> turn(-3, 3);
  std::vector<Pose> mounts{make_pose({0, 0, 1}, {M_PI, 0, 0}), make_pose({0, 0, 1}, {0, M_PI / 2, 0})};
  for (int i = 0; i < 6; ++i)
    mounts.push_back(make_pose({turn(random), 0, 0}, {turn(random), turn(random), turn(random)}));
  for (const Pose& mount : mounts) {
    const PlanarScan scan = deskewed_by_imu(mount, "imu", 1.2);
    EXPECT_EQ(scan.stamp, level.stamp);
    for (std::size_t i = 0; i < scan.beams; ++i) {
      if (scan.statuses[i] != BeamStatus::hit || level.statuses[i] != BeamStatus::hit) continue;
      ASSERT_NEAR(scan.ranges[i], level.ranges[i], 1e-4) << mount.linear();
    }
  }
}

TEST(MotionOfAnImu, WhosePlaceIsNotKnownIsCountedAndNamed) {
  PipelineBench bench(
      "vehicle: {imu_topic: /imu, speed_topic: /speed}\n"
      "sensors: {a: {topic: /a, pose: {xyz: [1, 0, 0]}}}\n");
  bench.pipeline.speed_message(1, bench_begin);
  bench.pipeline.turn_message(bench_begin, {0, 0, 1}, "imu", bench_begin);
  bench.pipeline.turn_message(bench_begin + ms(10), {0, 0, 1}, "imu", bench_begin + ms(10));
  const DiagnosticItem item = bench.item("motion", bench_begin + ms(10));
  EXPECT_EQ(test::value_of(item, "Frame not known"), "2");
  EXPECT_EQ(test::value_of(item, "Knots"), "0");
  EXPECT_EQ(item.message,
            "no pose of the vehicle yet, so scans are not deskewed; see that odometry is published: no tf "
            "from imu to base_link");
}

TEST(MotionOfAnImu, WithoutARecentSpeedIsNoMotion) {
  PipelineBench bench(
      "vehicle: {imu_topic: /imu, speed_topic: /speed}\n"
      "sensors: {a: {topic: /a, pose: {xyz: [1, 0, 0]}}}\n"
      "merged_scans: {m: {laserscan_topics: a, beams: 720, range_max: 20}}\n");
  const auto run = [&](int from, int to, bool with_speed) {
    for (int at = from; at < to; at += 10) {
      const Stamp now = bench_begin + ms(at);
      if (with_speed) bench.pipeline.speed_message(5, now);
      bench.pipeline.turn_message(now, {0, 0, 0}, "", now);
      if (at % 100 == 0) bench.give("a", round_scan("a", now - ms(200), 5, 721, ms(100)), now);
    }
    return bench.item("motion", bench_begin + ms(to));
  };
  EXPECT_EQ(run(0, 1000, false).health, Health::warn) << "no speed ever";
  EXPECT_EQ(run(1000, 3000, true).health, Health::ok);
  EXPECT_EQ(bench.value("merged m", "Motion", bench_begin + ms(3000)), "deskewed");
  const DiagnosticItem item = run(3000, 6000, false);
  EXPECT_EQ(item.health, Health::warn) << "the speed is that of seconds ago";
  EXPECT_THAT(item.message, testing::EndsWith("no speed comes on /speed; see that it is published"));
  EXPECT_NE(bench.value("merged m", "Motion", bench_begin + ms(6000)), "deskewed");
}

TEST(MotionOfAnImu, WithASpeedThatComesSeldomIsMotionUntilThreeOfItsPeriodsPass) {
  Watched watched;
  const auto run = [&](int from, int to, int period, double speed) {
    for (int at = from; at < to; at += 10) {
      const Stamp now = bench_begin + ms(at);
      if (period > 0 && at % period == 0) watched.motion.add_speed(speed, now);
      watched.motion.add_turn(now, {0, 0, 0}, "", now);
    }
    return test::value_of(motion_health(watched.motion.status(bench_begin + ms(to)).value()), "Knots");
  };
  EXPECT_EQ(run(0, 800, 800, 5), "51") << "of one speed no period is known";
  EXPECT_EQ(run(800, 4000, 800, 5), "371");
  EXPECT_EQ(run(4000, 8000, 0, 5), "532") << "2.4 s after the speed of 3.2 s";
  EXPECT_EQ(run(8000, 9000, 10, std::nan("")), "532") << "NaN is no speed";
  run(10'000, 30'000, 5000, 5);
  EXPECT_EQ(motion_health(watched.motion.status(bench_begin + ms(30'000)).value()).message,
            any_more + ": no speed comes on ; see that it is published")
      << "a speed of 3 s ago is too old, whatever its period";
}

TEST(MotionOfAnImu, SaysNoReasonAnyMoreThatHasGone) {
  Watched watched;
  const auto message = [&](int at) {
    return motion_health(watched.motion.status(bench_begin + ms(at)).value()).message;
  };
  watched.motion.add_turn(bench_begin, {0, 0, 0}, "", bench_begin);
  EXPECT_THAT(message(0), testing::EndsWith(": no speed comes on ; see that it is published"));
  watched.motion.restart();
  EXPECT_THAT(message(0), testing::EndsWith("see that odometry is published"));
  watched.motion.add_turn(bench_begin, {0, 0, 0}, "", bench_begin);
  watched.motion.add_speed(5, bench_begin);
  watched.motion.add_turn(bench_begin, {0, 0, 0}, "", bench_begin);
  EXPECT_EQ(message(1000), any_more);
}

TEST(MotionOfAnImu, CountsSpeedsAndRatesThatCannotBe) {
  PipelineBench bench(
      "vehicle: {imu_topic: /imu, speed_topic: /speed}\n"
      "sensors: {a: {topic: /a, pose: {xyz: [1, 0, 0]}}}\n");
  bench.pipeline.speed_message(1, bench_begin);
  bench.pipeline.speed_message(std::numeric_limits<double>::quiet_NaN(), bench_begin);
  bench.pipeline.turn_message(bench_begin, {0, 0, std::numeric_limits<double>::infinity()}, "", bench_begin);
  bench.pipeline.turn_message(bench_begin + ms(20), {0, 0, 1}, "", bench_begin + ms(20));
  bench.pipeline.turn_message(bench_begin + ms(10), {0, 0, 1}, "", bench_begin + ms(20));
  EXPECT_EQ(bench.value("motion", "Out of order", bench_begin + ms(20)), "3");
  EXPECT_EQ(bench.value("motion", "Knots", bench_begin + ms(20)), "1");
}

TEST(MotionOfPoses, OfAnotherFrameOnTheVehicleAreBroughtToItsBase) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(-3, 3);
  const auto merged = [&](const Pose& mount, const std::string& child) {
    PipelineBench bench(
        "vehicle: {odometry_topic: /odom}\n"
        "sensors: {a: {topic: /a, pose: {xyz: [1, 0, 0]}}}\n"
        "merged_scans: {m: {laserscan_topics: a, beams: 720, range_max: 20}}\n");
    bench.tf.set("base_link", "gnss", mount);
    for (int at = 0; at <= 400; at += 10) {
      const double t = at / 1000.0;
      const Pose base = make_pose({2 * t, 0.5 * t, 0}, {0, 0, 1.2 * t});
      bench.pipeline.pose_message(bench_begin + ms(at), child.empty() ? base : base * mount, child,
                                  bench_begin + ms(at));
    }
    bench.give("a", round_scan("a", bench_begin + ms(300), 5, 721, ms(100)), bench_begin + ms(400));
    return bench.sink.scans["m"].at(0);
  };
  const PlanarScan plain = merged(Pose::Identity(), "");
  for (int i = 0; i < 5; ++i) {
    const Pose mount = make_pose({any(random), any(random), 1}, {any(random), any(random), any(random)});
    const PlanarScan scan = merged(mount, "gnss");
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      if (scan.statuses[beam] != BeamStatus::hit || plain.statuses[beam] != BeamStatus::hit) continue;
      ASSERT_NEAR(scan.ranges[beam], plain.ranges[beam], 1e-4) << mount.matrix();
    }
  }
}

}  // namespace
}  // namespace lidard
