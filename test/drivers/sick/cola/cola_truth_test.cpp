// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The captures of simulated SICK scanners against the truth of their scenes.
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/identifier.h"
#include "drivers/registry/registry.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/simulate.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

/// Frames of a capture of the virtual vehicle, and the truth of every telegram.
class Watched final : public DriverOutput {
 public:
  Watched(const std::string& name, const std::string& model) {
    const std::string path = project_file("pcaps/" + name);
    sim::simulate(sim::load_scene(path + ".scene.yaml"), [&](const sim::SimPacket& packet) {
      if (packet.measurement != nullptr) truth.push_back(*packet.measurement);
      return true;
    });
    DriverConfig config;
    config.model = find_model(model);
    driver = config.model->make(config);
    PcapSource source(path + ".pcap");
    for (Packet packet; source.next(packet);) {
      if (packet.from.port != config.model->port) continue;
      identifier.add(packet);
      driver->receive(packet, *this);
    }
    driver->finish(*this);
    EXPECT_EQ(source.error(), "");
    EXPECT_EQ(driver->counters().rejected_total(), 0U);
    EXPECT_EQ(driver->counters().lost_packets, 0U);
    EXPECT_EQ(driver->counters().clock_steps, 0U);
    EXPECT_EQ(identifier.verdict(), config.model);
  }

  void scan(PlanarScan& scan) override {
    EXPECT_EQ(violation(scan), nullptr) << violation(scan);
    scans.push_back(scan);
  }
  void cloud(Cloud& cloud) override { clouds.push_back(cloud); }

  std::vector<sim::Measurement> truth;
  std::unique_ptr<Driver> driver;
  Identifier identifier;
  std::vector<PlanarScan> scans;
  std::vector<Cloud> clouds;
};

/// The noise of the scene, and half a millimetre of the wire.
constexpr double tolerance = 0.03;

void expect_truth(const PlanarScan& scan, const sim::Measurement& truth) {
  ASSERT_EQ(scan.beams, truth.slots.size());
  std::size_t hits = 0;
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const sim::SlotTruth& slot = truth.slots[i];
    ASSERT_NEAR(scan.angle(i), slot.azimuth, 2e-5) << i;
    if (!std::isfinite(slot.exact)) {
      ASSERT_EQ(scan.statuses[i], BeamStatus::none) << i;
      continue;
    }
    ++hits;
    ASSERT_EQ(scan.statuses[i], BeamStatus::hit) << i;
    ASSERT_NEAR(scan.ranges[i], slot.wire, 1e-5) << i;
    ASSERT_NEAR(scan.ranges[i], slot.exact, tolerance) << i;
  }
  EXPECT_GT(hits, scan.beams / 2);
  EXPECT_LT(hits, scan.beams) << "a sector of the room is open";
  EXPECT_NEAR(seconds(scan.stamp - truth.begin), 0, 1e-3);
  const Span between = truth.slots[1].time - truth.slots[0].time;
  EXPECT_NEAR(scan.time_increment, seconds(between), 1e-8);
}

TEST(ColaTruth, AConnectionOfAnLms111) {
  Watched seen("sick_lms111", "sick_lms1xx");
  ASSERT_GE(seen.scans.size(), 18U);
  for (std::size_t i = 0; i < seen.scans.size(); ++i) {
    expect_truth(seen.scans[i], seen.truth.at(i));
    EXPECT_EQ(seen.scans[i].intensities.size(), 541U);
  }
  EXPECT_EQ(seen.driver->info().serial, "18090001");
}

TEST(ColaTruth, ATextStreamJoinedInTheMiddle) {
  Watched seen("sick_tim571_text", "sick_tim7xx");  // nothing in it names the product
  ASSERT_GE(seen.scans.size(), 7U);
  for (std::size_t i = 0; i < seen.scans.size(); ++i) expect_truth(seen.scans[i], seen.truth.at(i));
}

TEST(ColaTruth, FourPlanesOfAnMrs1104) {
  Watched seen("sick_mrs1104", "sick_mrs1000");
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
    struct Keeper final : DriverOutput {
      void scan(PlanarScan& scan) override { scans.push_back(scan); }
      void cloud(Cloud& cloud) override { clouds.push_back(cloud); }
      std::vector<PlanarScan> scans;
      std::vector<Cloud> clouds;
    } out;
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
