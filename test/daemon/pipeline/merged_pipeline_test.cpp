// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Merged scans through the whole pipeline on a virtual clock: sources that die, poses that stop, virtual
// scans as sources.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/evidence/visibility.h"
#include "daemon/health/pipeline_health.h"
#include "daemon/pipeline/pipeline.h"
#include "test/daemon/pipeline/no_tf.h"
#include "test/sim/world/flat_world.h"
#include "test/sim/world/units.h"
#include "test/support/recording_sink.h"

namespace lidard {
namespace {

constexpr Stamp begin{1'700'000'000'000'000'000};

/// Two scanners of 25 Hz on the front corners of a vehicle in a room, as topics of other drivers.
struct Vehicle {
  explicit Vehicle(const std::string& merged, const std::string& vehicle = "")
      : config(parse_config(
            "vehicle: {footprint: [[-4, -1], [0, -1], [0, 1], [-4, 1]]" + vehicle +
                "}\n"
                "sensors:\n"
                "  left: {topic: /left, frame_id: left, pose: {xyz: [0, 1, 0.3], rpy_deg: [0, 0, 45]}}\n"
                "  right: {topic: /right, frame_id: right, pose: {xyz: [0, -1, 0.3], rpy_deg: [0, 0, -45]}}\n"
                "merged_scans: {m: {laserscan_topics: [left, right], beams: 720, range_max: 20, profile: "
                "strict, " +
                merged + "}}\n",
            "test")),
        pipeline(config, tf, sink) {
    world.add_box({0, 0}, {12, 9}, 0);
  }

  /// A sweep of the scanner that comes in at `at`, when its last beam is measured; by its stamps `before`
  /// that.
  void sweep(const std::string& name, Span at, Span before = {}) {
    sim::FlatScanner scanner;
    const double side = name == "left" ? 1 : -1;
    scanner.at = {0, side};
    scanner.yaw = side * 0.78539816339744831;
    scanner.increment = 0.0087266462599716477;
    sim::Rng rng(1);
    PlanarScan scan;
    scanner.measure(world, rng, scan);
    scan.frame_id = name;
    scan.stamp = begin + at - ms(30) - before;
    scan.time_increment = static_cast<float>(0.03 / static_cast<double>(scan.beams - 1));
    scan.scan_time = 0.04F;
    pipeline.scan_message(name, scan, begin + at);
    pipeline.tick(begin + at);
  }
  /// Both scanners from `from` to `to`; the right one is silent in [dead, alive).
  void drive(Span from, Span to, Span dead = Span::max(), Span alive = Span::max()) {
    for (Span at = from; at < to; at += ms(40)) {
      pipeline.tick(begin + at);
      sweep("left", at);
      if (at + ms(7) < dead || at + ms(7) >= alive) sweep("right", at + ms(7));
      for (double later : {15, 20, 25, 30, 35}) pipeline.tick(begin + at + ms(later));
    }
  }
  struct Output {
    const PlanarScan& scan;
    Stamp released;
  };
  std::vector<Output> outputs() {
    std::vector<Output> all;
    for (std::size_t i = 0; i < sink.count("m"); ++i)
      all.push_back({sink.scans["m"][i], sink.released["m"][i]});
    return all;
  }
  /// Share of the beams to the right of the vehicle, seen by the right scanner alone, that are not NaN.
  static double known_at_right(const PlanarScan& scan) {
    double known = 0, all = 0;
    for (std::size_t i = 0; i < scan.beams; ++i) {
      const double deg = static_cast<double>(scan.angle(i)) * 180 / 3.14159265358979;
      if (deg < -130 || deg > -110) continue;
      ++all;
      known += scan.statuses[i] == BeamStatus::invalid ? 0 : 1;
    }
    return known / all;
  }

  sim::FlatWorld world;
  NoTf tf;
  test::RecordingSink sink;
  Config config;
  Pipeline pipeline;
  HealthReporter reporter{pipeline, sink};
};

TEST(MergedPipeline, GoesOnAtItsRateWhenAScannerDiesAndItsSectorBecomesUnknown) {
  Vehicle vehicle("policy: complete");
  vehicle.drive(ms(0), ms(4000), ms(2000), ms(3000));
  Span worst{};
  const auto outputs = vehicle.outputs();
  for (std::size_t i = 1; i < outputs.size(); ++i) {
    const auto& before = outputs[i - 1];
    const auto& now = outputs[i];
    EXPECT_GT(now.scan.stamp, before.scan.stamp);
    worst = std::max(worst, now.released - before.released);
    const Span at = now.released - begin;
    // Its last sweep came at 1967; 0.3 periods after the next was due nothing is left of it.
    if (at > ms(2007 + 12) && at < ms(3000)) {
      EXPECT_EQ(Vehicle::known_at_right(now.scan), 0) << seconds(at);
    }
    if (at < ms(2000) || at > ms(3050)) {
      EXPECT_EQ(Vehicle::known_at_right(now.scan), 1) << seconds(at);
    }
  }
  EXPECT_LE(worst, ms(40 + 20));
  EXPECT_NEAR(static_cast<double>(outputs.size()), 100, 4);
}

TEST(MergedPipeline, SaysWithinHalfASecondThatASourceIsLostAndWhenItIsBack) {
  Vehicle vehicle("policy: complete");
  vehicle.drive(ms(0), ms(4000), ms(2000), ms(3000));
  const auto& told = vehicle.sink.healths["merged m"];
  const auto error = std::find_if(told.begin(), told.end(), [](const auto& change) {
    return change.first == Health::error && change.second > begin + ms(1000);
  });
  ASSERT_NE(error, told.end());
  EXPECT_EQ(error->second, begin + ms(1967 + 400) + Span(1));
  const auto back =
      std::find_if(error, told.end(), [](const auto& change) { return change.first == Health::ok; });
  ASSERT_NE(back, told.end());
  EXPECT_LE(back->second, begin + ms(3000 + 50));
}

TEST(MergedPipeline, RateIsKeptThroughALossButForTheOutputsThatTellOfItAtOnce) {
  Vehicle vehicle("rate: 20");
  vehicle.drive(ms(0), ms(6000), ms(2000), ms(4000));
  const auto outputs = vehicle.outputs();
  EXPECT_NEAR(static_cast<double>(outputs.size()), 120, 3);
  std::vector<Stamp> out_of_turn;
  for (std::size_t i = 1; i < outputs.size(); ++i) {
    const Span gap = outputs[i].released - outputs[i - 1].released;
    if (gap != ms(50)) out_of_turn.push_back(outputs[i].released);
    EXPECT_LE(gap, ms(50)) << i;
  }
  // Its last sweep came at 1967, the next one is overdue 0.3 periods after it was due; it is back at 4007.
  EXPECT_EQ(out_of_turn, (std::vector<Stamp>{begin + ms(1967 + 40 + 12) + Span(1), begin + ms(4007)}));
}

TEST(MergedPipeline, TellsWhatIsKnownOfEachBeam) {
  Vehicle vehicle("status_topic: known");
  vehicle.drive(ms(0), ms(1000));
  const PlanarScan& status = vehicle.sink.scans["known"].back();
  const PlanarScan& scan = vehicle.outputs().back().scan;
  ASSERT_EQ(status.beams, scan.beams);
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const auto seen = static_cast<BeamState>(status.intensities[i]);
    EXPECT_EQ(seen == BeamState::hit, scan.statuses[i] == BeamStatus::hit) << i;
    if (seen == BeamState::hit) {
      EXPECT_GT(status.ranges[i], scan.ranges[i] - 0.5F) << i;
    }
  }
}

TEST(MergedPipeline, IsDeskewedByOdometryAndSaysWhenItIsNot) {
  Vehicle vehicle("policy: complete", ", odometry_topic: /odom");
  // Turning on the spot at 1 rad/s while the sweeps, made at rest, pretend nothing of it: the room must come
  // out turned by what the vehicle turned during a sweep.
  const auto turn = [&](Span at) {
    Pose pose = Pose::Identity();
    pose.linear() = Eigen::AngleAxisd(seconds(at), Eigen::Vector3d::UnitZ()).toRotationMatrix();
    vehicle.pipeline.pose_message(begin + at, pose, "", begin + at);
  };
  for (Span at = ms(0); at < ms(1000); at += ms(40)) {
    turn(at);
    turn(at + ms(20));
    vehicle.sweep("left", at);
    vehicle.sweep("right", at + ms(7));
  }
  for (const DiagnosticItem& item : items_of(vehicle.pipeline, begin + ms(1000))) {
    if (item.name == "merged m") {
      EXPECT_EQ(item.message.find("as if the vehicle stood still"), std::string::npos) << item.message;
    }
  }
  vehicle.drive(ms(1000), ms(3000));
  const auto& item = vehicle.sink.item("merged m");
  EXPECT_EQ(item.health, Health::warn);
  EXPECT_NE(item.message.find("as if the vehicle stood still"), std::string::npos) << item.message;
  const PlanarScan& turned = vehicle.outputs()[12].scan;
  const PlanarScan& still = vehicle.outputs().back().scan;
  std::size_t differs = 0;
  for (std::size_t i = 0; i < still.beams; ++i)
    differs += std::abs(turned.ranges[i] - still.ranges[i]) > 0.02F ? 1 : 0;
  EXPECT_GT(differs, still.beams / 4);
}

/// Sweeps and poses for two seconds, their stamps so much before the arrivals; then the poses stop, or all
/// does.
DiagnosticItem motion_item(Span sweeps_before, Span poses_before, bool sweeps_go_on) {
  Vehicle vehicle("policy: complete", ", odometry_topic: /odom");
  vehicle.pipeline.set_message_clock(-std::min(sweeps_before, poses_before));
  for (Span at = ms(0); at < ms(4000); at += ms(40)) {
    if (at < ms(2000))
      vehicle.pipeline.pose_message(begin + at - poses_before, Pose::Identity(), "", begin + at);
    if (at < ms(2000) || sweeps_go_on) {
      vehicle.sweep("left", at, sweeps_before);
      vehicle.sweep("right", at + ms(7), sweeps_before);
    }
    if (at != ms(1960)) continue;
    for (const DiagnosticItem& item : items_of(vehicle.pipeline, begin + at + ms(10))) {
      if (item.name != "motion") continue;
      EXPECT_EQ(item.health, sweeps_before == poses_before ? Health::ok : Health::warn) << item.message;
    }
  }
  vehicle.pipeline.tick(begin + ms(4100));
  for (const DiagnosticItem& item : items_of(vehicle.pipeline, begin + ms(4100))) {
    if (item.name == "motion") return item;
  }
  return {};
}

TEST(MergedPipeline, MotionIsJudgedByTheSweepsClockAlsoWhereThatIsNotTheTimeOfArrival) {
  const Span simulated = std::chrono::hours(20 * 365 * 24);
  for (const Span before : {ms(0), simulated}) {
    const DiagnosticItem stopped = motion_item(before, before, true);
    EXPECT_EQ(stopped.health, Health::warn);
    EXPECT_NE(stopped.message.find("older than the newest scan"), std::string::npos) << stopped.message;
    const DiagnosticItem silent = motion_item(before, before, false);
    EXPECT_EQ(silent.health, Health::warn);
    EXPECT_EQ(silent.message, "no pose of the vehicle any more; see that odometry is published");
  }
}

TEST(MergedPipeline, PosesOfAnotherClockThanTheSweepsAreNamed) {
  const Span hour = std::chrono::hours(1);
  const std::string old = motion_item(ms(0), hour, true).message;
  EXPECT_NE(old.find("3600.00 s behind this computer's clock"), std::string::npos) << old;
}

TEST(MergedPipeline, LeavesOutWhatItCannotDeskewIfThatIsWished) {
  Vehicle vehicle("on_missing_motion: drop", ", odometry_topic: /odom");
  vehicle.drive(ms(0), ms(2000));  // in the first second all may still come
  EXPECT_TRUE(vehicle.outputs().empty());
  const auto& item = vehicle.sink.item("merged m");
  EXPECT_EQ(item.health, Health::error);
}

TEST(MergedPipeline, FollowsAClockThatWasSetBackAnHour) {
  Vehicle vehicle("policy: complete");
  vehicle.drive(ms(0), ms(1000));
  const std::size_t before = vehicle.outputs().size();
  const Span hour = std::chrono::hours(1);
  vehicle.drive(-hour, -hour + ms(1000));
  const auto outputs = vehicle.outputs();
  ASSERT_GT(outputs.size(), before + 20);
  const auto& first = outputs[before];
  EXPECT_LT(first.released, begin - hour + ms(1000));
  EXPECT_LT(first.scan.stamp, begin - hour + ms(1000));
  for (std::size_t i = before + 1; i < outputs.size(); ++i)
    EXPECT_GT(outputs[i].scan.stamp, outputs[i - 1].scan.stamp);
}

}  // namespace
}  // namespace lidard
