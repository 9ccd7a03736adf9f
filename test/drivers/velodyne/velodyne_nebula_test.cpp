// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "drivers/capture/pcap_source.h"
#include "drivers/velodyne/packet.h"
#include "test/support/captures.h"
#include "test/support/collector.h"
#include "test/support/pcd_reader.h"

namespace lidard {
namespace {

using test::NebulaPoint;
using test::Row;
using velodyne::DataPacket;

constexpr double slot_us = 2.304;
constexpr double block_us = 110.592;  // two firing sequences

double turn(double from_deg, double to_deg) { return std::remainder(to_deg - from_deg, 360); }

/// Where on the wire a point of the file comes from. Its time is that of single return: the number of the
/// block (not of the pair) times two firing sequences.
struct Place {
  int block, sequence, laser;
  double after_block_us() const { return (24 * sequence + laser) * slot_us; }
};

Place place_of(const NebulaPoint& point) {
  const long slot = std::lround(point.time_stamp_ns * 1e-3 / slot_us);
  return {static_cast<int>(slot / 48), static_cast<int>(slot % 48 / 24), static_cast<int>(slot % 24)};
}

/// What nebula makes of the azimuths of a dual return packet.
enum class Kind { interpolated, next_pairs, not_interpolated };

Kind kind_of(int block) {
  if (block >= 10) return Kind::not_interpolated;
  return block % 2 == 0 ? Kind::interpolated : Kind::next_pairs;
}

double nebula_azimuth(const DataPacket& packet, const Place& place) {
  const auto b = static_cast<std::size_t>(place.block);
  const double own = packet.azimuth(b) * 0.01;
  if (kind_of(place.block) == Kind::not_interpolated) return own;
  const double next = packet.azimuth(b / 2 * 2 + 2) * 0.01;
  if (kind_of(place.block) == Kind::next_pairs) return next;
  return own + turn(own, next) * place.after_block_us() / block_us;
}

std::vector<std::vector<std::uint8_t>> payloads_of(const std::string& path) {
  std::vector<std::vector<std::uint8_t>> all;
  PcapSource source(path);
  Packet packet;
  while (source.next(packet)) {
    if (packet.payload.size() == velodyne::packet_size)
      all.emplace_back(packet.payload.begin(), packet.payload.end());
  }
  return all;
}

/// The cloud of nebula and what this decoder makes of the same packets.
struct Comparison {
  std::vector<NebulaPoint> points;
  std::vector<std::vector<std::uint8_t>> packets;
  std::map<std::tuple<std::uint32_t, int, int, int>, Row> ours;  // packet, block, sequence, laser

  DataPacket packet(std::size_t i) const { return DataPacket({packets.at(i).data(), packets.at(i).size()}); }

  void decode(const std::string& path) {
    DriverConfig config;
    config.clock = ClockMode::arrival;
    config.keep_partial = config.keep_origins = true;
    for (const Row& row : test::decode_capture(path, "velodyne_vlp16", config).output.rows) {
      const auto in_pair_ns = row.offset_ns - 110'592 * (row.block / 2);
      ours[{row.packet, row.block, in_pair_ns >= 55'296 ? 1 : 0, row.laser}] = row;
    }
  }

  /// The packet that holds the point: the next one whose azimuth and slot it has.
  std::size_t find(const NebulaPoint& point, std::size_t from) const {
    const Place place = place_of(point);
    if (place.block > 11 || place.laser > 15) return packets.size();
    for (std::size_t i = from; i < packets.size(); ++i) {
      const auto slot = static_cast<std::size_t>(16 * place.sequence + place.laser);
      const std::uint8_t* bytes = packet(i).slots(static_cast<std::size_t>(place.block)) + 3 * slot;
      const int count = bytes[0] | bytes[1] << 8;
      const bool is_slot = count == std::lround(point.distance_m * 500) && bytes[2] == point.intensity;
      if (is_slot && std::fabs(turn(nebula_azimuth(packet(i), place), point.azimuth_deg)) < 0.006) return i;
    }
    return packets.size();
  }
};

/// Smallest and largest difference of azimuth of a kind of point, theirs - ours, deg.
struct Range {
  double low = 360, high = -360;
  std::size_t count = 0;
  void add(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
    ++count;
  }
};

TEST(VelodyneNebula, EveryPointOfItsCloudIsOursAndEveryDifferenceOfAzimuthIsExplained) {
  LIDARD_NEED_CAPTURE(capture, "velodyne/vlp16_dual_603.pcap");
  LIDARD_NEED_CAPTURE(cloud, "velodyne/vlp16_dual_603.nebula.pcd");
  Comparison both;
  both.points = test::read_nebula_pcd(cloud);
  ASSERT_EQ(both.points.size(), 14831U);
  both.packets = payloads_of(capture);
  both.decode(capture);
  std::map<Kind, Range> azimuth;
  double worst_xy = 0;
  std::size_t at = 0;
  for (const NebulaPoint& point : both.points) {
    at = both.find(point, at);
    ASSERT_LT(at, both.packets.size()) << "no slot of any packet explains the point";
    const Place place = place_of(point);
    const auto found =
        both.ours.find({static_cast<std::uint32_t>(at), place.block, place.sequence, place.laser});
    ASSERT_NE(found, both.ours.end());
    const Row& ours = found->second;
    ASSERT_NEAR(ours.distance_m, point.distance_m, 1e-6 * ours.distance_m);
    ASSERT_EQ(static_cast<int>(ours.intensity), point.intensity);
    ASSERT_EQ(ours.ring, point.channel);
    const Kind kind = kind_of(place.block);
    azimuth[kind].add(turn(ours.azimuth_deg, point.azimuth_deg));
    if (kind == Kind::interpolated)
      worst_xy = std::max(worst_xy, std::hypot(ours.x - point.x, ours.y - point.y) / ours.distance_m);
  }
  // It interpolates the even blocks with the step to the next pair and rounds to 0.01 deg; an odd block gets
  // the azimuth of the next pair; the last pair is not interpolated.
  EXPECT_EQ(azimuth[Kind::interpolated].count + azimuth[Kind::next_pairs].count +
                azimuth[Kind::not_interpolated].count,
            14831U);
  EXPECT_GE(azimuth[Kind::interpolated].low, -0.025);
  EXPECT_LE(azimuth[Kind::interpolated].high, 0.025);
  EXPECT_LE(worst_xy, 0.025 * M_PI / 180 + 1e-5);
  EXPECT_GE(azimuth[Kind::next_pairs].low, 0.05);
  EXPECT_LE(azimuth[Kind::next_pairs].high, 0.41);
  EXPECT_GE(azimuth[Kind::not_interpolated].low, -0.335);
  EXPECT_LE(azimuth[Kind::not_interpolated].high, 1e-4);
  for (const auto& [kind, range] : azimuth)
    std::printf("kind %d: %zu points, theirs - ours %.4f to %.4f deg\n", static_cast<int>(kind), range.count,
                range.low, range.high);
}

}  // namespace
}  // namespace lidard
