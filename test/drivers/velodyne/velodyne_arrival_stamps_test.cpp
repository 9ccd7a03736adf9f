// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/support/velodyne_wire.h"

namespace lidard {
namespace {

using test::Columns;
using test::WirePacket;

// As recorded (chalmers-revere/opendlv.core, atwallshort.pcap): 593 rpm, and arrivals that lie up to 0.1 ms
// beside an even rhythm.
constexpr double recorded_turn_deg = 0.1138;
constexpr double recorded_jitter_s = 100e-6;

std::vector<WirePacket> stream(double turns) {
  sim::VelodyneOptions options;
  options.start_azimuth_deg = 300;
  options.turn_deg = recorded_turn_deg;
  return test::spin({"velodyne_hdl64e_s1", sim::ReturnMode::strongest, ""}, turns, options);
}

struct Heard {
  Columns out;
  Counters counters;
};

Heard play(const std::vector<WirePacket>& packets, ClockMode clock = ClockMode::smooth) {
  DriverConfig config;
  config.model = find_model("velodyne_hdl64e_s1");
  config.clock = clock;
  config.keep_partial = true;
  const auto driver = config.model->make(config);
  Heard heard;
  for (const WirePacket& packet : packets) test::give(*driver, packet, heard.out);
  driver->finish(heard.out);
  heard.counters = driver->counters();
  return heard;
}

std::vector<WirePacket> jittered(std::vector<WirePacket> packets) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> late_s(0, 2 * recorded_jitter_s);
  for (WirePacket& packet : packets) packet.arrival = packet.arrival + span_from_seconds(late_s(random));
  return packets;
}

TEST(VelodyneArrivalStamps, LostPacketsAreCountedByTheAzimuthInSpiteOfTheJitter) {
  const auto sent = jittered(stream(4));
  for (const double share : {0.01, 0.1, 0.4}) {
    std::mt19937 random(3);
    std::bernoulli_distribution is_lost(share);
    std::vector<WirePacket> received;
    std::uint64_t lost = 0, pending = 0;
    for (const WirePacket& packet : sent) {
      if (is_lost(random)) {
        pending += received.empty() ? 0U : 1U;
        continue;
      }
      lost += std::exchange(pending, 0);
      received.push_back(packet);
    }
    const Heard heard = play(received);
    EXPECT_EQ(heard.counters.lost_packets, lost) << share;
    EXPECT_EQ(heard.counters.rejected_total(), 0U) << share;
  }
}

TEST(VelodyneArrivalStamps, WholeTurnsThatAreLostAreToldByTheArrival) {
  for (const int turns : {1, 2, 5}) {
    auto packets = jittered(stream(2.0 + turns));
    const auto per_turn = static_cast<std::ptrdiff_t>(std::lround(360 / (12 * recorded_turn_deg)));
    packets.erase(packets.begin() + 150, packets.begin() + 150 + per_turn * turns);
    EXPECT_EQ(play(packets).counters.lost_packets, static_cast<std::uint64_t>(per_turn * turns));
  }
}

TEST(VelodyneArrivalStamps, LateAndRepeatedPacketsAreToldFromNewOnes) {
  auto packets = stream(2);
  const auto straight = play(packets);
  std::swap(packets[100], packets[101]);
  std::swap(packets[100].arrival, packets[101].arrival);
  packets.insert(packets.begin() + 200, packets[199]);
  const Heard heard = play(packets);
  EXPECT_EQ(heard.counters.reordered, 1U);
  EXPECT_EQ(heard.counters.rejected[static_cast<std::size_t>(Reject::duplicate)], 1U);
  EXPECT_EQ(heard.counters.lost_packets, 0U);
  EXPECT_EQ(heard.out.points, straight.out.points);
}

TEST(VelodyneArrivalStamps, AStalledHostIsNoLoss) {
  auto packets = stream(3);
  // 60 ms in which nothing was fetched, then all at once.
  const Stamp fetched = packets[300].arrival + std::chrono::milliseconds(60);
  for (std::size_t i = 300; i < packets.size() && packets[i].arrival < fetched; ++i)
    packets[i].arrival = fetched + std::chrono::microseconds(i - 300);
  const Heard heard = play(packets);
  EXPECT_EQ(heard.counters.lost_packets, 0U);
  EXPECT_EQ(heard.counters.rejected_total(), 0U);
  EXPECT_EQ(heard.counters.clock_steps, 0U);
}

TEST(VelodyneArrivalStamps, AJumpOfTheAzimuthLosesNothing) {
  auto packets = stream(1);
  sim::VelodyneOptions elsewhere;
  elsewhere.start_azimuth_deg = 20;
  elsewhere.turn_deg = recorded_turn_deg;
  const Stamp end = packets.back().arrival;
  std::size_t n = 0;
  for (WirePacket packet : test::spin({"velodyne_hdl64e_s1", sim::ReturnMode::strongest, ""}, 1, elsewhere)) {
    packet.arrival = end + ++n * std::chrono::microseconds(384);
    packets.push_back(packet);
  }
  EXPECT_EQ(play(packets).counters.rejected_total(), 0U);
}

TEST(VelodyneArrivalStamps, TheSmoothClockTakesMostOfTheJitterOut) {
  const auto even = stream(60);
  const auto packets = jittered(even);
  const Heard heard = play(packets);
  double worst_s = 0;
  std::uint32_t seen = 0;
  for (const Columns::Frame& frame : heard.out.frames) {
    for (const CloudColumn& column : frame.columns) {
      if (column.block != 0 || column.packet < 3000) continue;
      ++seen;
      // The last of its 12 blocks fired 32 us before it was sent.
      const Stamp sent = even.at(column.packet).arrival - std::chrono::microseconds(384);
      worst_s = std::max(worst_s, std::abs(seconds(column.stamp - sent)));
    }
  }
  EXPECT_GT(seen, 10000U);
  EXPECT_LT(worst_s, recorded_jitter_s);
}

TEST(VelodyneArrivalStamps, ASensorWithAnotherPeriodIsFollowed) {
  auto packets = stream(60);
  const Stamp start = packets.front().arrival;
  // 2600 packets/s and 0.3 % beside it.
  for (WirePacket& packet : packets)
    packet.arrival = start + span_from_seconds(seconds(packet.arrival - start) * 1.003);
  const Heard heard = play(packets);
  const Columns::Frame& last = heard.out.frames.back();
  EXPECT_LT(std::abs(seconds(packets.back().arrival - last.end)), 2e-3);
  EXPECT_EQ(heard.counters.lost_packets, 0U);
  EXPECT_EQ(heard.counters.clock_steps, 0U);
}

}  // namespace
}  // namespace lidard
