// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/microscan3.h"

#include <gtest/gtest.h>

#include <cmath>

#include "test/sim/servers/test_scene.h"

namespace {

using namespace lidard;
using namespace lidard::sim;

// One scan: its datagrams as they came, and the instance put together.
struct Scan {
  std::vector<KeptPacket> datagrams;
  std::vector<std::uint8_t> instance;
  ByteView view() const { return {instance.data(), instance.size()}; }
  const Measurement& truth() const { return datagrams.back().measurement; }
};

std::vector<Scan> scans(const Scene& scene) {
  std::vector<Scan> all(1);
  for (KeptPacket& packet : all_packets(scene)) {
    Scan& scan = all.back();
    scan.instance.insert(scan.instance.end(), packet.payload.begin() + 24, packet.payload.end());
    scan.datagrams.push_back(std::move(packet));
    if (scan.datagrams.back().measured) all.emplace_back();
  }
  all.pop_back();
  return all;
}

std::vector<Scan> scans(const std::string& options, const std::string& keys = "") {
  return scans(room("sick_microscan3", keys + "options: {" + options + "}"));
}

TEST(VirtualMicroScan3, DatagramsCarryTheHeaderOfTheManual) {
  const auto all = scans("serial: 4711");
  ASSERT_GE(all.size(), 2U);
  for (std::size_t s = 0; s < 2; ++s) {
    ASSERT_EQ(all[s].datagrams.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
      const ByteView payload = all[s].datagrams[i].view();
      EXPECT_EQ(payload.sub(0, 6).text(), "MS3 MD");
      EXPECT_EQ(payload.u8(6), 1);
      EXPECT_EQ(payload.u8(7), 0);
      EXPECT_EQ(payload.le32(8), all[s].instance.size());
      EXPECT_EQ(payload.le32(12), s);
      EXPECT_EQ(payload.le32(16), 1436 * i);
      EXPECT_LE(payload.size(), 1460U);
    }
  }
}

TEST(VirtualMicroScan3, InstancePointsToItsBlocks) {
  const auto all = scans("serial: 4711, first_scan: 77, protective_field: 6");
  const ByteView instance = all[1].view();
  EXPECT_EQ(instance.u8(0), 'R');
  EXPECT_EQ(instance.le32(4), 4711U);
  EXPECT_EQ(instance.le32(16), 1U);
  EXPECT_EQ(instance.le32(20), 78U);
  std::size_t expected = 76;
  for (const auto& [entry, size] :
       {std::pair<std::size_t, std::size_t>{32, 16}, {36, 24}, {40, 4 + 4 * 706}, {44, 96 + 89}, {48, 264}}) {
    EXPECT_EQ(instance.le16(entry), expected);
    EXPECT_EQ(instance.le16(entry + 2), size);
    expected += size;
  }
  EXPECT_EQ(instance.size(), expected);
  EXPECT_EQ(instance.le32(52), 0U) << "no sixth block";
}

TEST(VirtualMicroScan3, DerivedValuesSayWhatTheBeamsDo) {
  const auto all = scans("");
  const Scan& scan = all.front();
  const std::size_t at = scan.view().le16(36);
  EXPECT_EQ(scan.view().le16(at), 1) << "mm";
  EXPECT_EQ(scan.view().le16(at + 2), 706) << "275 deg in steps of 0.39 deg";
  EXPECT_EQ(scan.view().le16(at + 4), 30);
  const double start = scan.view().le32s(at + 8) / 4194304.0;
  const double step = scan.view().le32s(at + 12) / 4194304.0;
  EXPECT_EQ(start, -47.5);
  EXPECT_NEAR(step, 0.39, 0.5 / 4194304);
  EXPECT_EQ(scan.view().le32(at + 16), 33U) << "32.5 us, rounded";
  const Measurement& truth = scan.truth();
  ASSERT_EQ(truth.slots.size(), 706U);
  for (std::size_t i = 0; i < 706; ++i) {
    const double beam = static_cast<double>(i);
    EXPECT_NEAR(truth.slots[i].azimuth / rad_per_deg, start + beam * step, 1e-9);
    EXPECT_NEAR(static_cast<double>((truth.slots[i].time - truth.begin).count()), beam * 30e6 * step / 360,
                0.51);
    // The device counts from the right, ROS from the front.
    const double ros = std::atan2(truth.slots[i].xyz.y(), truth.slots[i].xyz.x());
    EXPECT_NEAR(std::remainder(ros - (start + beam * step - 90) * rad_per_deg, 2 * pi_d), 0, 1e-9);
  }
}

TEST(VirtualMicroScan3, DistancesAreMillimetresAndStatusSaysValid) {
  const auto all = scans("");
  const Scan& scan = all.front();
  const std::size_t at = scan.view().le16(40);
  EXPECT_EQ(scan.view().le32(at), 706U);
  for (std::size_t i = 0; i < 706; ++i) {
    const SlotTruth& slot = scan.truth().slots[i];
    ASSERT_EQ(scan.view().le16(at + 4 + 4 * i), std::lround(slot.exact * 1000));
    ASSERT_EQ(scan.view().u8(at + 6 + 4 * i), 50);
    ASSERT_EQ(scan.view().u8(at + 7 + 4 * i), 1);
    ASSERT_NEAR(std::max(std::abs(slot.xyz.x()), std::abs(slot.xyz.y())), 5, 1e-9);
  }
}

TEST(VirtualMicroScan3, StatusTellsNoEchoReflectorAndDirt) {
  const std::string tape = "  - wall: {from: [2, -0.3], to: [2, 0.3], z: [-1, 1], reflectivity: 1.5}\n";
  const auto all = scans(room("sick_microscan3", "range_max: 4, options: {dirty_deg: [[100, 110]]}", tape));
  const Scan& scan = all.front();
  const std::size_t at = scan.view().le16(40);
  std::array<int, 3> seen{};
  for (std::size_t i = 0; i < 706; ++i) {
    const SlotTruth& slot = scan.truth().slots[i];
    const double angle = slot.azimuth / rad_per_deg;
    const unsigned status = scan.view().u8(at + 7 + 4 * i);
    const bool dirty = angle >= 100 && angle <= 110;
    const bool hit = slot.exact < no_hit;
    ASSERT_EQ(status, dirty ? 0x10U : hit ? 0x09U : 0x03U) << i;
    ASSERT_TRUE(dirty ? std::isnan(slot.wire) : (slot.wire < no_hit) == hit) << i;
    ++seen[dirty ? 0 : hit ? 1 : 2];
  }
  for (const int n : seen) EXPECT_GT(n, 0);
  EXPECT_EQ(scan.view().u8(scan.view().le16(32)) & 0x04U, 0x04U) << "contamination warning";
}

TEST(VirtualMicroScan3, IntrusionBitsMarkTheBeamsInsideTheField) {
  const auto all = scans("protective_field: 6");
  const Scan& scan = all.front();
  const std::size_t at = scan.view().le16(44);
  EXPECT_EQ(scan.view().le32(at), 89U);
  for (std::size_t i = 0; i < 706; ++i) {
    const bool bit = (scan.view().u8(at + 4 + i / 8) >> i % 8 & 1U) != 0;
    ASSERT_EQ(bit, scan.truth().slots[i].exact < 6) << i;
  }
  for (std::size_t path = 1; path < 24; ++path) EXPECT_EQ(scan.view().le32(at + 89 + 4 * path), 0U);
}

TEST(VirtualMicroScan3, FragmentsLeaveOneAfterAnotherOnceTheLastBeamFired) {
  const auto all = scans("", "phase_ms: 15, latency_us: 50, ");
  for (std::size_t s = 0; s < all.size(); ++s) {
    const Measurement& truth = all[s].truth();
    EXPECT_EQ(truth.begin.ns,
              Stamp{1767226643'500000000}.ns + 15000000 + static_cast<std::int64_t>(s) * 30000000);
    EXPECT_EQ(truth.end, truth.slots.back().time);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ((all[s].datagrams[i].time - truth.end).count(), 50000 + 20000 * static_cast<std::int64_t>(i));
    }
  }
}

TEST(VirtualMicroScan3, StampIsTheDevicesDateAndTimeOfDay) {
  const auto all = scans("", "clock_offset: 86400, ");
  const ByteView instance = all.front().view();
  EXPECT_EQ(instance.le16(24), 19724 + 1) << "2026-01-01 is day 19724 after 1972-01-01";
  EXPECT_EQ(instance.le32(28), (17U * 60 + 23) * 1000 + 500 + 22) << "made after the last beam";
}

TEST(VirtualMicroScan3, ApplicationDataHoldTheVehiclesSpeed) {
  const auto all =
      scans(room("sick_microscan3", "options: {}", "vehicle: {path: [{duration: 9, speed: -1.5}]}\n"));
  const std::size_t at = all.front().view().le16(48);
  EXPECT_EQ(static_cast<std::int16_t>(all.front().view().le16(at + 56)), -1500);
}

}  // namespace
