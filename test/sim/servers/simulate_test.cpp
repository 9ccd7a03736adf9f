// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/simulate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test/sim/servers/test_scene.h"
#include "test/support/captures.h"

namespace {

using namespace lidard;
using namespace lidard::sim;

const char* const drive_past = "vehicle: {path: [{duration: 9, speed: 10, yaw_rate_deg: 90}]}\n";

TEST(Simulation, IsTheSameEachTime) {
  const std::string keys = "noise: 0.02, jitter_us: 500, options: {}";
  const Scene scene = room("velodyne_vlp16", keys, drive_past);
  const auto first = all_packets(scene);
  const auto second = all_packets(scene);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    ASSERT_EQ(first[i].time, second[i].time);
    ASSERT_EQ(first[i].payload, second[i].payload);
  }
  Scene other = scene;
  other.seed = 2;
  EXPECT_NE(all_packets(other).front().payload, first.front().payload);
}

TEST(Simulation, EachBeamLooksFromWhereTheVehicleIsAtThatMoment) {
  for (const char* model : {"velodyne_vlp16", "sick_microscan3"}) {
    const Scene scene =
        room(model, "pose: {xyz: [0.5, 0.2, 0.1], rpy_deg: [2, -3, 40]}, options: {}", drive_past);
    for (const KeptPacket& packet : all_packets(scene)) {
      for (const SlotTruth& slot : packet.measurement.slots) {
        const Pose sensor = scene.vehicle_at(slot.time) * scene.sensors[0].mount;
        const Eigen::Vector3d world = sensor * slot.xyz;
        ASSERT_NEAR(std::max(std::abs(world.x()), std::abs(world.y())), 5, 1e-9) << model;
      }
    }
  }
}

TEST(Simulation, AKnockedMountSeesFromElsewhereFromThenOn) {
  const Scene scene =
      room("sick_microscan3",
           "pose: {xyz: [0.5, 0.2, 0.1]}, knocked: {at: 0.1, xyz: [0.03, 0, 0], rpy_deg: [0, 0, "
           "0.5]}, options: {}",
           "", "0.2");
  const SensorEntry& sensor = scene.sensors[0];
  EXPECT_TRUE(sensor.knocked.isApprox(make_pose({0.53, 0.2, 0.1}, {0, 0, 0.5 * rad_per_deg}), 1e-12));
  std::size_t after = 0;
  for (const KeptPacket& packet : all_packets(scene)) {
    for (const SlotTruth& slot : packet.measurement.slots) {
      const bool is_knocked = scene.elapsed(slot.time) >= 0.1;
      after += is_knocked ? 1 : 0;
      const Eigen::Vector3d world = (is_knocked ? sensor.knocked : sensor.mount) * slot.xyz;
      ASSERT_NEAR(std::max(std::abs(world.x()), std::abs(world.y())), 5, 1e-9);
    }
  }
  EXPECT_GT(after, 100U);
}

TEST(Simulation, OffsetsOfRangesAreAddedPerScannerOrPerLaser) {
  const auto off_by = [](const std::string& model, const std::string& offset, const auto& expected) {
    const Scene scene = room(model, "range_offset: " + offset + ", options: {}");
    std::size_t judged = 0;
    for (const KeptPacket& packet : all_packets(scene)) {
      for (const SlotTruth& slot : packet.measurement.slots) {
        if (!std::isfinite(slot.exact) || !std::isfinite(slot.wire)) continue;
        ASSERT_NEAR(slot.wire - slot.exact, expected(slot), 0.003) << model;  // steps of the wire
        ++judged;
      }
    }
    EXPECT_GT(judged, 300U) << model;
  };
  off_by("sick_microscan3", "0.02", [](const SlotTruth&) { return 0.02; });
  off_by("velodyne_vlp16", "[0.02, -0.03]", [](const SlotTruth& slot) {
    return slot.laser == 0 ? 0.02 : slot.laser == 1 ? -0.03 : 0;
  });
}

TEST(Simulation, OdometryIsWrongByItsScalesAndItsWalk) {
  const std::string path = "vehicle: {path: [{duration: 100, speed: 1, yaw_rate_deg: 9}], odometry: {";
  const auto last = [&](const std::string& keys, unsigned seed = 1) {
    Scene scene = room("sick_microscan3", "options: {}", path + keys + "}}\n", "20");
    scene.seed = seed;
    const auto readings = odometry_of(scene);
    EXPECT_EQ(readings.size(), 1001U);
    EXPECT_NEAR(seconds(readings.back().stamp - scene.start), 20, 1e-6);
    return readings.back().place;
  };
  EXPECT_NEAR(last("scale: 1").yaw, pi_d, 1e-9);
  EXPECT_NEAR(last("scale: 1").y, 40 / pi_d, 1e-6);
  EXPECT_NEAR(last("scale: 1.01").y, 40.4 / pi_d, 1e-6);
  EXPECT_NEAR(last("turn_scale: 0.5").yaw, pi_d / 2, 1e-9);
  double turns = 0;
  for (unsigned seed = 1; seed <= 40; ++seed)
    turns += std::pow(last("turn_noise_deg: 0.1", seed).yaw - pi_d, 2) / 40;
  EXPECT_NEAR(std::sqrt(turns) / rad_per_deg, 0.1 * std::sqrt(20), 0.12) << "the root of the way";
}

TEST(Simulation, VehicleMotionTakesAPointFromOneMomentToAnother) {
  const Scene scene = room("sick_microscan3", "options: {}", drive_past);
  const Stamp later = scene.start + Span(80'000'000);
  const Eigen::Vector3d point(1, 2, 3);
  const Eigen::Vector3d moved = vehicle_motion(scene, scene.start, later) * point;
  EXPECT_TRUE((scene.vehicle_at(later) * moved).isApprox(scene.vehicle_at(scene.start) * point, 1e-12));
  EXPECT_GT((moved - point).norm(), 0.5);
}

TEST(Simulation, PacketsOfAllSensorsComeInTheOrderInWhichTheyLeave) {
  const Scene scene = load_scene(test::project_file("pcaps/demo.scene.yaml"));
  Stamp last;
  std::vector<std::size_t> packets(scene.sensors.size());
  std::vector<std::uint64_t> next_number(scene.sensors.size());
  simulate(scene, [&](const SimPacket& packet) {
    EXPECT_GE(packet.time, last);
    EXPECT_LT(packet.time, scene.start + scene.duration);
    last = packet.time;
    ++packets[packet.sensor];
    if (packet.measurement != nullptr) {
      EXPECT_EQ(packet.measurement->number, next_number[packet.sensor]++);
      EXPECT_GT(packet.time, packet.measurement->end);
    }
    return true;
  });
  EXPECT_EQ(packets[0], 3 * next_number[0]);
  EXPECT_EQ(next_number[0], 66U);
  EXPECT_EQ(next_number[1], 66U);
  EXPECT_EQ(packets[2], 1507U);
}

TEST(Simulation, StopsWhenTheReceiverHasEnough) {
  int calls = 0;
  simulate(room("velodyne_vlp16", "options: {}"), [&](const SimPacket&) { return ++calls < 3; });
  EXPECT_EQ(calls, 3);
}

TEST(Simulation, JitterDelaysWithinItsBoundAndNeverSwapsPackets) {
  const auto kept = all_packets(room("velodyne_vlp16", "latency_us: 30, jitter_us: 2000, options: {}"));
  Stamp last;
  std::int64_t largest = 0;
  for (const KeptPacket& packet : kept) {
    const std::int64_t delay = (packet.time - packet.measurement.end).count();
    EXPECT_GE(delay, 30'000);
    EXPECT_LE(delay, 2'030'001);
    EXPECT_GT(packet.time, last);
    largest = std::max(largest, delay);
    last = packet.time;
  }
  EXPECT_GT(largest, 1'000'000);
}

TEST(Simulation, NoiseIsOnTheWireAndNotInTheTruth) {
  const auto kept = all_packets(room("velodyne_vlp16", "noise: 0.03, options: {}"));
  double squares = 0;
  double n = 0;
  for (const KeptPacket& packet : kept) {
    for (const SlotTruth& slot : packet.measurement.slots) {
      ASSERT_NEAR(std::max(std::abs(slot.xyz.x()), std::abs(slot.xyz.y())), 5, 1e-9);
      squares += (slot.wire - slot.exact) * (slot.wire - slot.exact);
      n += 1;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / n), 0.03, 0.001);
}

TEST(Simulation, VehiclesOwnBodyMovesAlongAndGroundIsSeen) {
  const std::string extra =
      "ground: {z: -1}\nvehicle: {path: [{duration: 9, speed: 10}], body: [{box: {center: [-2, 0, 0], size: "
      "[1, 9, "
      "1]}}]}\n";
  const auto kept = all_packets(room("sick_microscan3", "options: {}", extra));
  const SlotTruth& rightmost =
      kept.back().measured ? kept.back().measurement.slots.front() : kept[2].measurement.slots.front();
  // -47.5 deg of the device is -137.5 deg in ROS: it meets the front face of the body, 1.5 m behind the
  // sensor.
  EXPECT_NEAR(rightmost.xyz.x(), -1.5, 1e-9);
  const auto ground = all_packets(room("velodyne_vlp16", "options: {}", "ground: {z: -1}\n"));
  EXPECT_NEAR(ground.front().measurement.slots[0].xyz.z(), -1, 1e-9);
}

}  // namespace
