// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Sensors send now and then an azimuth of exactly 36000, a whole turn, which means 0: such packets decode as
// if they had 0 there.
#include <gtest/gtest.h>

#include <random>

#include "drivers/capture/pcap_source.h"
#include "drivers/model.h"
#include "drivers/registry/identifier.h"
#include "drivers/registry/registry.h"
#include "test/support/captures.h"
#include "test/support/collector.h"
#include "test/support/velodyne_wire.h"

namespace lidard {
namespace {

using test::WirePacket;
using Packets = std::vector<WirePacket>;

constexpr std::size_t block_bytes = 100;
constexpr unsigned whole_turn = 36000;

unsigned azimuth(const WirePacket& packet, std::size_t block) {
  return ByteView(packet.bytes.data(), packet.bytes.size()).le16(block * block_bytes + 2);
}

void set_azimuth(WirePacket& packet, std::size_t block, unsigned value) {
  packet.bytes[block * block_bytes + 2] = static_cast<std::uint8_t>(value & 0xFFU);
  packet.bytes[block * block_bytes + 3] = static_cast<std::uint8_t>(value >> 8U);
}

Packets data_packets(const std::string& path) {
  PcapSource source(path);
  Packets packets;
  Packet packet;
  while (source.next(packet)) {
    if (packet.payload.size() == 1206)
      packets.push_back({{packet.payload.begin(), packet.payload.end()}, packet.arrival});
  }
  return packets;
}

struct Played {
  test::Collector output;
  Counters counters;
  const Model* model = nullptr;
};

Played play(const char* model, const Packets& packets) {
  DriverConfig config;
  config.model = find_model(model);
  config.keep_origins = config.keep_partial = true;
  const auto driver = config.model->make(config);
  Played played;
  Identifier identifier;
  for (const WirePacket& packet : packets) {
    EXPECT_EQ(give(*driver, packet, played.output), Reject::none);
    identifier.add({{packet.bytes.data(), packet.bytes.size()}, packet.arrival, {{}, 2368}, {{}, 2368}});
  }
  driver->finish(played.output);
  played.counters = driver->counters();
  played.model = identifier.verdict();
  return played;
}

void expect_same(const Played& a, const Played& b) {
  EXPECT_EQ(a.model, b.model);
  EXPECT_EQ(a.counters.frames, b.counters.frames);
  EXPECT_EQ(a.counters.lost_packets, b.counters.lost_packets);
  EXPECT_EQ(a.counters.rejected_total(), 0U);
  EXPECT_EQ(b.counters.rejected_total(), 0U);
  ASSERT_EQ(a.output.rows.size(), b.output.rows.size());
  ASSERT_GT(a.output.rows.size(), 1000U);
  for (std::size_t i = 0; i < a.output.rows.size(); ++i) {
    const test::Row &p = a.output.rows[i], &q = b.output.rows[i];
    ASSERT_EQ(p.frame, q.frame);
    ASSERT_EQ(p.packet, q.packet);
    ASSERT_EQ(p.block, q.block);
    ASSERT_EQ(p.laser, q.laser);
    ASSERT_EQ(p.stamp_ns, q.stamp_ns);
    ASSERT_EQ(p.azimuth_deg, q.azimuth_deg);
    ASSERT_EQ(p.x, q.x);
    ASSERT_EQ(p.y, q.y);
    ASSERT_EQ(p.z, q.z);
    ASSERT_EQ(p.time, q.time);
  }
}

/// The same stream turned so that the given block looks at 0.
Packets turned_to_zero(Packets packets, std::size_t packet, std::size_t block) {
  const unsigned turned = azimuth(packets.at(packet), block);
  for (WirePacket& p : packets) {
    for (std::size_t b = 0; b < 12; ++b) {
      if (azimuth(p, b) < whole_turn) set_azimuth(p, b, (azimuth(p, b) + whole_turn - turned) % whole_turn);
    }
  }
  return packets;
}

/// A recording turned so that the given block looks at 0, which is then a whole turn in one of both.
void expect_whole_turn_is_zero(const char* model, const Packets& recording, std::size_t packet,
                               std::size_t block) {
  const Packets zero = turned_to_zero(recording, packet, block);
  Packets whole = zero;
  for (std::size_t b = 0; b < 12; ++b) {
    if (azimuth(whole[packet], b) == 0) set_azimuth(whole[packet], b, whole_turn);
  }
  ASSERT_EQ(azimuth(whole[packet], block), whole_turn);
  expect_same(play(model, zero), play(model, whole));
}

struct Recording {
  const char* name;
  const char* model;
};

TEST(VelodyneWholeTurn, ABlockOfARecordingAt36000IsABlockAt0) {
  for (const Recording& recording :
       {Recording{"vlp16_strongest_1000", "velodyne_vlp16"}, Recording{"vlp16_last_1500", "velodyne_vlp16"},
        Recording{"vlp16_dual_603", "velodyne_vlp16"}, Recording{"hdl32e_gprmc_876", "velodyne_hdl32e"},
        Recording{"vlp32c_fov_379", "velodyne_vlp32c"},
        Recording{"vls128_strongest_2193", "velodyne_vls128"}}) {
    LIDARD_NEED_CAPTURE(path, std::string("velodyne/") + recording.name + ".pcap");
    SCOPED_TRACE(recording.name);
    const Packets packets = data_packets(path);
    for (const std::size_t block : {std::size_t{0}, std::size_t{4}, std::size_t{11}})
      expect_whole_turn_is_zero(recording.model, packets, packets.size() / 2, block);
  }
}

/// Each zero of a stream is written as 0 or as a whole turn, as chance has it; the blocks of one firing also
/// differently.
TEST(VelodyneWholeTurn, AnyMixOf0And36000IsTheSameForEveryModelAndMode) {
  for (const test::ModelMode& which : test::model_modes()) {
    SCOPED_TRACE(which.name());
    const Packets stream = test::spin(which, 1.3);
    const Packets zero = turned_to_zero(stream, stream.size() / 2, 4);
    Packets mixed = zero;
    std::mt19937 random(36000);
    std::size_t changed = 0;
    for (WirePacket& packet : mixed) {
      for (std::size_t b = 0; b < 12; ++b) {
        if (azimuth(packet, b) != 0 || random() % 2 == 0) continue;
        set_azimuth(packet, b, whole_turn);
        ++changed;
      }
    }
    EXPECT_GT(changed, 0U);
    expect_same(play(which.model.c_str(), zero), play(which.model.c_str(), mixed));
  }
}

TEST(VelodyneWholeTurn, MoreThanAWholeTurnIsRefused) {
  const test::ModelMode which{"velodyne_vlp16", sim::ReturnMode::strongest, ""};
  Packets packets = test::spin(which, 0.1);
  const auto driver = [] {
    DriverConfig config;
    config.model = find_model("velodyne_vlp16");
    return config.model->make(config);
  }();
  test::Columns out;
  set_azimuth(packets[0], 3, whole_turn + 1);
  EXPECT_EQ(give(*driver, packets[0], out), Reject::field);
}

}  // namespace
}  // namespace lidard
