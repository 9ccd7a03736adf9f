// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "drivers/registry/registry.h"
#include "drivers/velodyne/packet.h"
#include "drivers/velodyne/raw_packets.h"
#include "test/sim/servers/velodyne_stream.h"

namespace lidard {
namespace {

using velodyne::RawPacketCollector;

/// The driver of a VLP-16 that hands on packets, and what it handed on.
struct Roof final : FrameReceiver {
  explicit Roof(std::optional<FrameStamp> stamp = FrameStamp::first) {
    config.model = find_model("velodyne_vlp16");
    config.frame_id = "roof";
    config.raw_packets = stamp;
    config.time_offset = std::chrono::milliseconds(250);
    driver = config.model->make(config);
  }
  void take(const sim::SimulatedPacket& packet) {
    driver->receive({packet.view(), packet.arrival, {}, {{}, packet.port}}, *this);
  }
  void scan(PlanarScan&) override {}
  void cloud(Cloud&) override { packets_at_cloud.push_back(count()); }
  void message(const DeviceMessage& message) override {
    if (const auto* one = std::get_if<RawPackets>(&message)) raw.push_back(*one);
  }
  std::size_t count() const {
    std::size_t sum = 0;
    for (const RawPackets& one : raw) sum += one.arrivals.size();
    return sum;
  }

  DriverConfig config;
  std::unique_ptr<Driver> driver;
  std::vector<RawPackets> raw;
  std::vector<std::size_t> packets_at_cloud;
};

std::vector<sim::SimulatedPacket> half_a_second(double telemetry_hz = 0) {
  sim::VelodyneSetup setup;
  setup.duration = std::chrono::milliseconds(450);
  setup.telemetry_hz = telemetry_hz;
  return simulate_velodyne(setup);
}

TEST(VelodyneRawPackets, HoldEveryDataPacketOnceInOrderAndNoOthers) {
  Roof roof;
  std::vector<std::uint8_t> sent;
  std::vector<Stamp> arrivals;
  for (const auto& packet : half_a_second(20)) {
    roof.take(packet);
    if (packet.payload.size() != velodyne::packet_size) continue;
    sent.insert(sent.end(), packet.payload.begin(), packet.payload.end());
    arrivals.push_back(packet.arrival + roof.config.time_offset);
  }
  roof.driver->finish(roof);
  std::vector<std::uint8_t> bytes;
  std::vector<Stamp> stamps;
  for (const RawPackets& one : roof.raw) {
    EXPECT_EQ(one.frame_id, "roof");
    EXPECT_EQ(one.arrivals.front(), Span(0)) << "FrameStamp::first";
    bytes.insert(bytes.end(), one.bytes.begin(), one.bytes.end());
    for (const Span arrival : one.arrivals) stamps.push_back(one.stamp + arrival);
  }
  EXPECT_EQ(bytes, sent);
  EXPECT_EQ(stamps, arrivals);
}

TEST(VelodyneRawPackets, OfARevolutionComeBeforeItsCloudTheOneThatEndedItIncluded) {
  Roof roof;
  std::vector<std::size_t> received;
  std::size_t taken = 0;
  for (const auto& packet : half_a_second()) {
    const std::size_t clouds = roof.packets_at_cloud.size();
    roof.take(packet);
    ++taken;
    if (roof.packets_at_cloud.size() > clouds) received.push_back(taken);
  }
  ASSERT_GE(received.size(), 3U);
  EXPECT_EQ(roof.packets_at_cloud, received);
}

TEST(VelodyneRawPackets, AreStampedByTheLastOneWhereCloudsAre) {
  Roof roof(FrameStamp::last);
  const auto all = half_a_second();
  for (const auto& packet : all) roof.take(packet);
  roof.driver->finish(roof);
  EXPECT_EQ(roof.raw.back().arrivals.back(), Span(0));
  EXPECT_EQ(roof.raw.back().stamp, all.back().arrival + std::chrono::milliseconds(250));
}

TEST(VelodyneRawPackets, FollowAnotherOffsetAtOnce) {
  Roof roof;
  const auto first = half_a_second().front();
  roof.take(first);
  DriverConfig wanted = roof.config;
  wanted.time_offset = Span(0);
  roof.driver->change(wanted);
  roof.driver->finish(roof);
  EXPECT_EQ(roof.raw.at(0).stamp, first.arrival);
}

TEST(VelodyneRawPackets, AreBoundedWhereNoRevolutionEndsAndHoldRejectedOnes) {
  Roof roof;
  auto packet = half_a_second().front();
  packet.payload[0] = 0;  // no packet of a Velodyne
  for (std::size_t i = 0; i < RawPacketCollector::most_packets + 10; ++i) {
    packet.arrival = packet.arrival + std::chrono::milliseconds(1);
    roof.take(packet);
  }
  EXPECT_TRUE(roof.packets_at_cloud.empty());
  ASSERT_EQ(roof.raw.size(), 1U);
  EXPECT_EQ(roof.raw[0].arrivals.size(), RawPacketCollector::most_packets);
  roof.driver->finish(roof);
  EXPECT_EQ(roof.count(), RawPacketCollector::most_packets + 10) << "not one is lost";
}

TEST(VelodyneRawPackets, OfBeforeAndAfterAGapAreNotInOneMessage) {
  Roof roof;
  const auto packets = half_a_second();
  for (std::size_t i = 0; i < packets.size(); ++i) {
    sim::SimulatedPacket packet = packets[i];
    if (i >= packets.size() / 2) packet.arrival = packet.arrival + std::chrono::hours(1);
    roof.take(packet);
  }
  roof.driver->finish(roof);
  EXPECT_EQ(roof.count(), packets.size());
  for (const RawPackets& one : roof.raw)
    EXPECT_LT(one.arrivals.back() - one.arrivals.front(), std::chrono::seconds(1));
}

TEST(VelodyneRawPackets, AreForgottenWhenTheInputStartsAgain) {
  const auto all = half_a_second();
  Roof roof;
  for (std::size_t i = 0; i < 10; ++i) roof.take(all[i]);
  roof.driver->restart();
  roof.take(all[0]);
  roof.driver->finish(roof);
  EXPECT_EQ(roof.count(), 1U);
}

TEST(VelodyneRawPackets, AreNotHandedOnUnlessAskedFor) {
  Roof roof(std::nullopt);
  for (const auto& packet : half_a_second()) roof.take(packet);
  roof.driver->finish(roof);
  EXPECT_TRUE(roof.raw.empty());
  EXPECT_GE(roof.packets_at_cloud.size(), 3U);
}

}  // namespace
}  // namespace lidard
