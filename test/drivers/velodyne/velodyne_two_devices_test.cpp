// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Two sensors with one address, and what looks like them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <random>

#include "core/base/alternation.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/packet.h"
#include "test/support/collector.h"
#include "test/support/velodyne_wire.h"

namespace lidard {
namespace {

using test::ModelMode;
using test::WirePacket;

/// The same sensor's packets as of another one: its clock is ahead by `ahead`, its rotor by `turned` degrees.
std::vector<WirePacket> other(std::vector<WirePacket> packets, std::chrono::microseconds ahead,
                              unsigned turned) {
  for (WirePacket& packet : packets) {
    std::uint32_t us = 0;
    std::memcpy(&us, &packet.bytes[velodyne::stamp_offset], 4);
    us = static_cast<std::uint32_t>((us + ahead.count()) % 3'600'000'000);
    std::memcpy(&packet.bytes[velodyne::stamp_offset], &us, 4);
    for (std::size_t block = 0; block < velodyne::blocks_per_packet; ++block) {
      std::uint8_t* const at = &packet.bytes[block * velodyne::block_size + 2];
      const unsigned azimuth = (at[0] + 256U * at[1] + 100 * turned) % 36000;
      at[0] = static_cast<std::uint8_t>(azimuth), at[1] = static_cast<std::uint8_t>(azimuth >> 8U);
    }
  }
  return packets;
}

/// All packets by their arrival, those of `second` later by `late`.
std::vector<WirePacket> beside(std::vector<WirePacket> first, const std::vector<WirePacket>& second,
                               Span late) {
  for (WirePacket packet : second) {
    packet.arrival = packet.arrival + late;
    first.push_back(std::move(packet));
  }
  std::stable_sort(first.begin(), first.end(),
                   [](const auto& a, const auto& b) { return a.arrival < b.arrival; });
  return first;
}

/// What two devices are found by what the driver says of each packet, and how many seconds after the first.
std::pair<std::string, double> two_devices(const ModelMode& which, const std::vector<WirePacket>& packets) {
  DriverConfig config;
  config.model = find_model(which.model);
  const auto driver = config.model->make(config);
  test::Collector out;
  Alternation devices(8, std::chrono::seconds(10));
  for (const WirePacket& packet : packets) {
    const Verdict verdict = driver->receive({{packet.bytes.data(), packet.bytes.size()},
                                             packet.arrival,
                                             {IpAddress::v4(192, 168, 1, 201), 2368},
                                             {{}, 2368}},
                                            out);
    out.clouds.clear();
    devices.observe(verdict.device, packet.arrival);
    if (const std::string both = devices.both(packet.arrival); !both.empty())
      return {both, seconds(packet.arrival - packets.front().arrival)};
  }
  return {"", 0};
}

using namespace std::chrono_literals;

class EveryVelodyne : public testing::TestWithParam<ModelMode> {};

TEST_P(EveryVelodyne, IsTakenForTwoWithinHalfASecondIfASecondOneHasItsAddress) {
  const auto packets = test::spin(GetParam(), 3);
  // Clocks that started at any time, at about the same time, and clocks that follow one receiver.
  for (const auto& [ahead, turned] : {std::pair<std::chrono::microseconds, unsigned>(777s, 0),
                                      {-1234567us, 200},
                                      {300ms, 0},
                                      {20ms, 123},
                                      {0us, 90}}) {
    if (GetParam().model.find("hdl64e") != std::string::npos) GTEST_SKIP() << "not found for this family";
    const auto [who, after] = two_devices(GetParam(), beside(packets, other(packets, ahead, turned), 300us));
    EXPECT_NE(who, "") << ahead.count() << " us ahead, turned by " << turned;
    EXPECT_LT(after, 0.5);
  }
}

TEST_P(EveryVelodyne, IsOneWhereItsPacketsComeTwiceLateOrWithGaps) {
  const auto packets = test::spin(GetParam(), 3);
  EXPECT_EQ(two_devices(GetParam(), packets).first, "");
  for (const Span late : {Span(0), Span(100us), Span(50ms)})
    EXPECT_EQ(two_devices(GetParam(), beside(packets, packets, late)).first, "") << late.count();
  std::mt19937 random(7);
  auto disordered = packets, lossy = packets;
  for (WirePacket& packet : disordered) packet.arrival = packet.arrival + Span(random() % 20'000'000);
  EXPECT_EQ(two_devices(GetParam(), beside(disordered, {}, Span(0))).first, "");
  lossy.erase(std::remove_if(lossy.begin(), lossy.end(), [&](const auto&) { return random() % 3 == 0; }),
              lossy.end());
  EXPECT_EQ(two_devices(GetParam(), lossy).first, "");
  // Two cables that carry a packet each in turn, one of them longer.
  auto bonded = packets;
  for (std::size_t i = 0; i < bonded.size(); i += 2) bonded[i].arrival = bonded[i].arrival + 30ms;
  EXPECT_EQ(two_devices(GetParam(), beside(bonded, {}, Span(0))).first, "");
}

TEST_P(EveryVelodyne, IsOneThatIsExchangedOrStartsAgain) {
  const auto packets = test::spin(GetParam(), 3);
  const auto spare = other(packets, 500s, 77);
  auto exchanged = beside(packets, spare, 3s);
  EXPECT_EQ(two_devices(GetParam(), exchanged).first, "");
  exchanged = beside(exchanged, packets, 6s);  // and back
  EXPECT_EQ(two_devices(GetParam(), exchanged).first, "");
}

INSTANTIATE_TEST_SUITE_P(VelodyneTwoDevices, EveryVelodyne, testing::ValuesIn(test::model_modes()),
                         [](const auto& of) {
                           std::string name = of.param.name();
                           std::replace_if(
                               name.begin(), name.end(), [](char c) { return std::isalnum(c) == 0; }, '_');
                           return name;
                         });

}  // namespace
}  // namespace lidard
