// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The captures of simulated SICK scanners against the truth of their scenes.
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/drivers/watched_capture.h"

namespace lidard::test {
namespace {

/// The noise of the scene, and half a millimetre of the wire.
constexpr double tolerance = 0.03;

void expect_cola_truth(const WatchedCapture& seen) {
  EXPECT_EQ(seen.identifier.verdict(), seen.model);
  for (std::size_t i = 0; i < seen.scans.size(); ++i) {
    const PlanarScan& scan = seen.scans[i];
    const sim::Measurement& truth = seen.truth.at(i);
    expect_truth(scan, truth, tolerance);
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      if (!std::isfinite(truth.slots[beam].exact)) continue;
      ASSERT_NEAR(scan.ranges[beam], truth.slots[beam].wire, 1e-5);
    }
    EXPECT_NEAR(seconds(scan.stamp - truth.begin), 0, 1e-3);
    EXPECT_NEAR(scan.time_increment, seconds(truth.slots[1].time - truth.slots[0].time), 1e-8);
  }
}

TEST(ColaTruth, AConnectionOfAnLms111) {
  WatchedCapture seen("sick_lms111", "sick_lms1xx");
  ASSERT_GE(seen.scans.size(), 18U);
  expect_cola_truth(seen);
  for (const PlanarScan& scan : seen.scans) EXPECT_EQ(scan.intensities.size(), 541U);
  EXPECT_EQ(seen.driver->info().serial, "18090001");
}

TEST(ColaTruth, ATextStreamJoinedInTheMiddle) {
  WatchedCapture seen("sick_tim571_text", "sick_tim7xx");  // nothing in it names the product
  ASSERT_GE(seen.scans.size(), 7U);
  expect_cola_truth(seen);
}

TEST(ColaTruth, FourPlanesOfAnMrs1104) {
  WatchedCapture seen("sick_mrs1104", "sick_mrs1000");
  expect_cola_truth(seen);
  ASSERT_GE(seen.clouds.size(), 3U);
  // The telegrams before the first plane of a turn belong to no whole cloud.
  std::size_t telegram = 0;
  while (seen.truth.at(telegram).slots.front().laser != 0) ++telegram;
  for (const Cloud& cloud : seen.clouds) {
    std::size_t point = 0;
    for (std::size_t plane = 0; plane < 4; ++plane, ++telegram) {
      for (const sim::SlotTruth& slot : seen.truth.at(telegram).slots) {
        if (!std::isfinite(slot.exact)) continue;
        ASSERT_LT(point, cloud.size());
        const CloudPoint p = cloud.points()[point++];
        ASSERT_EQ(p.ring, slot.laser);
        ASSERT_NEAR((Eigen::Vector3d(p.x, p.y, p.z) - slot.xyz).norm(), 0, tolerance);
        ASSERT_NEAR(seconds(cloud.stamp - slot.time) + p.time, 0, 1e-3);
      }
    }
    EXPECT_EQ(point, cloud.size());
  }
}

/// A product in both dialects, standing in a room; its telegrams go right into the driver.
class EveryProduct : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryProduct, SeesTheRoomWhereItIs) {
  const Model* model = find_model(GetParam());
  ASSERT_NE(model, nullptr);
  for (const std::string dialect : {"a", "b"}) {
    const sim::Scene scene = sim::parse_scene(
        "start: 2026-01-01T00:17:23.5Z\nduration: 1\nsensors:\n  it: {model: " + GetParam() +
            ", from: '10.0.0.1:2112', to: '10.0.0.2:40000', options: {dialect: " + dialect + R"(}}
objects:
  - wall: {from: [3, -3], to: [3, 2], z: [-1, 1]}
  - wall: {from: [3, 2], to: [-2, 2], z: [-1, 1]}
  - wall: {from: [-2, -3], to: [3, -3], z: [-1, 1]}
)",
        "room");
    DriverConfig config;
    config.model = model;
    const auto driver = model->make(config);
    Collector out;
    std::vector<sim::Measurement> truth;
    sim::simulate(scene, [&](const sim::SimPacket& from_sim) {
      if (from_sim.measurement != nullptr) truth.push_back(*from_sim.measurement);
      if (from_sim.to_device) return true;
      Packet packet;
      packet.payload = from_sim.payload;
      packet.arrival = from_sim.time;
      packet.transport = Transport::tcp;
      driver->receive(packet, out);
      return true;
    });
    EXPECT_EQ(driver->counters().rejected_total(), 0U);
    EXPECT_EQ(driver->counters().lost_packets, 0U);
    if (model->kind == FrameKind::cloud) {
      EXPECT_GE(out.clouds.size(), 10U);
      continue;
    }
    ASSERT_GE(out.scans.size(), 5U);
    for (std::size_t i = 0; i < out.scans.size(); ++i) {
      const PlanarScan& scan = out.scans[i];
      ASSERT_EQ(violation(scan), nullptr);
      const auto& slots = truth.at(i).slots;
      ASSERT_EQ(scan.beams, slots.size());
      for (std::size_t beam = 0; beam < scan.beams; ++beam) {
        ASSERT_NEAR(std::remainder(scan.angle(beam) - slots[beam].azimuth, 2 * 3.14159265358979), 0, 5e-5);
        ASSERT_TRUE(!std::isfinite(slots[beam].wire) ||
                    std::abs(scan.ranges[beam] - slots[beam].wire) < 1e-5);
      }
      // The clock needs no time: it is right from the first telegram on.
      ASSERT_NEAR(seconds(scan.stamp - truth[i].begin), 0, 1e-3);
    }
  }
}

std::vector<std::string> products() {
  std::vector<std::string> names;
  for (const Model& model : models()) {
    if (model.protocol == "CoLa A/B") names.emplace_back(model.name);
  }
  return names;
}
INSTANTIATE_TEST_SUITE_P(Cola, EveryProduct, ::testing::ValuesIn(products()),
                         [](const auto& each) { return each.param; });

}  // namespace
}  // namespace lidard::test
