// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/stream_facts.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "drivers/capture/pcap_source.h"
#include "test/support/captures.h"

namespace lidard::velodyne {
namespace {

const Endpoint sensor{IpAddress::v4(192, 168, 1, 201), 2368};
const Endpoint here{IpAddress::v4(192, 168, 1, 77), 2368};

/// Hands a packet of this device time to `facts`, turned by `rpm`.
void add(StreamFacts& facts, double seconds, double rpm, std::size_t size = 1206) {
  std::array<std::uint8_t, 1206> bytes{};
  const auto us = static_cast<std::uint32_t>(std::llround(std::fmod(seconds, 3600.0) * 1e6));
  const auto azimuth = static_cast<unsigned>(std::llround(seconds * rpm * 600)) % 36000U;
  bytes[0] = 0xFF;
  bytes[1] = 0xEE;
  bytes[2] = static_cast<std::uint8_t>(azimuth);
  bytes[3] = static_cast<std::uint8_t>(azimuth >> 8U);
  for (std::size_t i = 0; i < 4; ++i) bytes[1200 + i] = static_cast<std::uint8_t>(us >> (8 * i));
  bytes[1204] = 0x39;
  Packet packet{};
  packet.payload = ByteView(bytes.data(), size);
  packet.arrival = Stamp{std::llround(seconds * 1e9)};
  packet.from = sensor;
  packet.to = here;
  facts.add(packet);
}

TEST(StreamFacts, KnowNothingBeforeTheFirstDataPacket) {
  StreamFacts facts;
  add(facts, 1, 600, 512);
  EXPECT_FALSE(facts.last_arrival());
  EXPECT_FALSE(facts.rpm());
  EXPECT_EQ(facts.returns(), nullptr);
}

TEST(StreamFacts, MeasureTheSpeed) {
  for (const double rpm : {300.0, 597.0, 1200.0}) {
    StreamFacts facts;
    for (double t = 0; t < 1.2; t += 0.001327) add(facts, t, rpm);
    ASSERT_TRUE(facts.rpm());
    EXPECT_NEAR(*facts.rpm(), rpm, 1);
    EXPECT_STREQ(facts.returns(), "Dual");
    EXPECT_EQ(facts.destination().to_string(), here.to_string());
  }
}

TEST(StreamFacts, LeaveOutGapsReorderingAndTheTurnOfTheHour) {
  StreamFacts facts;
  int n = 0;
  for (double t = 3599.0; t < 3601.5; t += 0.001327, ++n) {
    if (n % 50 > 40) continue;                        // packets lost
    if (n % 75 == 3) add(facts, t - 0.0027, 600);     // one comes late
    add(facts, t + (n % 200 > 100 ? 0.05 : 0), 600);  // a field of view with a gap
  }
  ASSERT_TRUE(facts.rpm());
  EXPECT_NEAR(*facts.rpm(), 600, 2);
}

TEST(StreamFacts, AreThoseOfARealCapture) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_strongest_1000.pcap");
  PcapSource source(path);
  StreamFacts facts;
  Packet packet{};
  while (source.next(packet)) facts.add(packet);
  EXPECT_STREQ(facts.returns(), "Strongest");
  ASSERT_TRUE(facts.rpm());
  EXPECT_NEAR(*facts.rpm(), 600, 12);
}

}  // namespace
}  // namespace lidard::velodyne
