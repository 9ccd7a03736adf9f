// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/repeater.h"

#include <gtest/gtest.h>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/packet.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard::sim {
namespace {

TEST(Repeater, StampsAndTimesGoOnFromTurnToTurn) {
  PcapSource capture(test::project_file("pcaps/vlp16_dual.pcap"));
  Repeater repeater(capture);
  ASSERT_GT(repeater.packets(), 10U);
  std::vector<std::uint32_t> stamps;
  std::vector<Stamp> arrivals;
  repeater.play(3, [&](const Packet& packet) {
    arrivals.push_back(packet.arrival);
    if (packet.payload.size() == velodyne::packet_size)
      stamps.push_back(velodyne::DataPacket(packet.payload).stamp_us());
  });
  EXPECT_EQ(arrivals.size(), 3 * repeater.packets());
  ASSERT_GT(stamps.size(), 30U);
  for (std::size_t i = 1; i < arrivals.size(); ++i) ASSERT_LT(arrivals[i - 1], arrivals[i]) << i;
  constexpr std::uint32_t hour_us = 3'600'000'000;  // the capture lies across a full hour
  const std::uint32_t step = stamps[1] - stamps[0];
  for (std::size_t i = 1; i < stamps.size(); ++i)
    ASSERT_NEAR(static_cast<double>((std::uint64_t{hour_us} + stamps[i] - stamps[i - 1]) % hour_us), step, 2)
        << i;
}

TEST(Repeater, TheDriverSeesOneStreamWithoutLoss) {
  PcapSource capture(test::project_file("pcaps/vlp16_dual.pcap"));
  Repeater repeater(capture);
  DriverConfig config;
  config.model = find_model("velodyne_vlp16");
  const auto driver = config.model->make(config);
  test::Collector output;
  repeater.play(5, [&](const Packet& packet) { driver->receive(packet, output); });
  driver->finish(output);
  EXPECT_EQ(driver->counters().packets + driver->counters().other_packets, 5 * repeater.packets());
  EXPECT_EQ(driver->counters().lost_packets, 0U);
  EXPECT_EQ(driver->counters().clock_steps, 0U);
  EXPECT_EQ(driver->counters().rejected_total(), 0U);
}

}  // namespace
}  // namespace lidard::sim
