// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/models.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard {
namespace {

using test::Decoded;
using test::Row;

Decoded decode_all(const std::string& path) {
  DriverConfig config;
  config.clock = ClockMode::arrival;
  config.keep_partial = true;
  config.keep_origins = true;
  return test::decode_capture(path, "velodyne_vlp16", config);
}

struct Sums {
  std::size_t returns;
  long counts;
  long intensity;
};

Sums sums_of(const Decoded& decoded) {
  Sums sums{decoded.output.rows.size(), 0, 0};
  for (const Row& row : decoded.output.rows) {
    sums.counts += std::lround(row.distance_m / 0.002);
    sums.intensity += std::lround(row.intensity);
  }
  return sums;
}

struct Golden {
  unsigned packet;
  int block, slot, laser;
  double after_stamp_us, azimuth_deg, distance_m, intensity, x, y, z;
};

void expect_golden(const Decoded& decoded, const Golden& golden) {
  const std::int64_t ns = std::llround(golden.after_stamp_us * 1000);
  const auto found =
      std::find_if(decoded.output.rows.begin(), decoded.output.rows.end(), [&](const Row& row) {
        return row.packet == golden.packet && row.block == golden.block && row.laser == golden.laser &&
               std::abs(row.offset_ns - ns) <= 2;
      });
  ASSERT_NE(found, decoded.output.rows.end()) << golden.packet << "/" << golden.block << "/" << golden.slot;
  EXPECT_NEAR(found->azimuth_deg, golden.azimuth_deg, 0.001);
  EXPECT_NEAR(found->distance_m, golden.distance_m, 1e-9);
  EXPECT_EQ(found->intensity, golden.intensity);
  EXPECT_NEAR(found->x, golden.x, 1e-4);
  EXPECT_NEAR(found->y, golden.y, 1e-4);
  // The vectors come from the angles alone; the beam's height on the axis is the manual's vertical
  // correction.
  const auto& row = *static_cast<const velodyne::ModelRow*>(find_model("velodyne_vlp16")->row);
  const double z_offset = row.laser[golden.laser].z_offset_mm * 1e-3;
  EXPECT_NEAR(found->z, golden.z + z_offset, 1e-4);
}

TEST(VelodyneCapture, GpsRecordingHasThePublishedSumsAndVectors) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_gps_293.pcap");
  const Decoded decoded = decode_all(path);
  const Sums sums = sums_of(decoded);
  EXPECT_EQ(sums.returns, 73486U);
  EXPECT_EQ(sums.counts, 47738942);
  EXPECT_EQ(sums.intensity, 3548881);
  EXPECT_EQ(decoded.counters.packets, 293U);
  EXPECT_EQ(decoded.counters.other_packets, 57U);
  EXPECT_EQ(decoded.counters.rejected_total(), 0U);
  EXPECT_EQ(decoded.counters.lost_packets, 0U);
  // Computed in double precision from the published payloads, independently of this decoder.
  const std::vector<Golden> vectors = {
      {3, 0, 1, 1, 2.304, 133.21830, 845 * 0.002, 77, -1.1571, -1.2314, 0.0295},
      {3, 1, 7, 7, 126.720, 133.64807, 851 * 0.002, 71, -1.1660, -1.2224, 0.2074},
      {3, 5, 3, 3, 559.872, 135.22489, 889 * 0.002, 70, -1.2604, -1.2506, 0.0931},
      {3, 6, 10, 10, 686.592, 135.67295, 900 * 0.002, 62, -1.2828, -1.2530, -0.1569},
      {3, 10, 7, 7, 1122.048, 137.23807, 926 * 0.002, 68, -1.3496, -1.2480, 0.2257},
      {3, 11, 13, 13, 1246.464, 137.69784, 948 * 0.002, 56, -1.3664, -1.2434, 0.4265}};
  for (const Golden& golden : vectors) expect_golden(decoded, golden);
}

TEST(VelodyneCapture, DualRecordingHasThePublishedSumsAndVectors) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_dual_603.pcap");
  const Decoded decoded = decode_all(path);
  const Sums sums = sums_of(decoded);
  EXPECT_EQ(sums.returns, 116827U);
  EXPECT_EQ(sums.counts, 167544123);
  EXPECT_EQ(sums.intensity, 4881504);
  EXPECT_EQ(decoded.counters.rejected_total(), 0U);
  const std::vector<Golden> vectors = {
      {100, 0, 1, 1, 2.304, 239.66833, 1290 * 0.002, 7, -1.3027, 2.2265, 0.0450},
      {100, 1, 7, 7, 16.128, 239.71833, 4143 * 0.002, 55, -4.1471, 7.1021, 1.0098},
      {100, 5, 5, 5, 232.704, 240.50167, 1931 * 0.002, 10, -1.8944, 3.3486, 0.3366},
      {100, 6, 11, 11, 357.120, 240.95167, 4334 * 0.002, 97, -4.1314, 7.4384, 1.6539},
      {100, 10, 7, 7, 569.088, 241.71833, 1915 * 0.002, 1, -1.8012, 3.3477, 0.4668},
      {100, 11, 13, 13, 582.912, 241.76833, 4724 * 0.002, 50, -4.3547, 8.1107, 2.1253}};
  for (const Golden& golden : vectors) expect_golden(decoded, golden);
}

TEST(VelodyneCapture, DualRecordingHas2167DifferingSecondReturns) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_dual_1500.pcap");
  const Decoded decoded = decode_all(path);
  EXPECT_EQ(decoded.counters.rejected_total(), 0U);
  using Key = std::tuple<std::uint32_t, int, std::int64_t>;  // packet, laser, firing
  std::map<Key, double> first;
  for (const Row& row : decoded.output.rows) {
    if (row.echo == 0) first[{row.packet, row.laser, row.offset_ns}] = row.distance_m;
  }
  std::size_t differing = 0;
  for (const Row& row : decoded.output.rows) {
    if (row.echo == 0) continue;
    const auto other = first.find({row.packet, row.laser, row.offset_ns});
    if (other == first.end() || other->second != row.distance_m) ++differing;
  }
  EXPECT_EQ(differing, 2167U);
}

TEST(VelodyneCapture, EveryVlp16RecordingDecodesWithoutARejectedPacket) {
  for (const char* name :
       {"vlp16_strongest_84", "vlp16_2014_says_hdl32", "vlp16_strongest_1000", "vlp16_last_1500"}) {
    LIDARD_NEED_CAPTURE(path, std::string("velodyne/") + name + ".pcap");
    const Decoded decoded = decode_all(path);
    EXPECT_EQ(decoded.counters.rejected_total(), 0U) << name;
    EXPECT_EQ(decoded.counters.lost_packets, 0U) << name;
    EXPECT_GT(decoded.output.rows.size(), 10000U) << name;
    for (std::size_t f = 1; f < decoded.output.clouds.size(); ++f) {
      EXPECT_GT(decoded.output.clouds[f].stamp, decoded.output.clouds[f - 1].stamp) << name;
    }
  }
}

TEST(VelodyneCapture, WholeRevolutionsHaveAllTheirFiringSequences) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_strongest_1000.pcap");
  const Decoded decoded = decode_all(path);
  std::size_t complete = 0;
  for (const Cloud& cloud : decoded.output.clouds) {
    if (!cloud.complete) continue;
    ++complete;
    EXPECT_NEAR(static_cast<double>(cloud.columns.size()), 0.1 / 55.296e-6, 4);
    EXPECT_LT(cloud.columns.front().azimuth, 0.2 * M_PI / 180);
    EXPECT_GT(cloud.columns.back().azimuth, 359.7 * M_PI / 180);
  }
  EXPECT_EQ(complete, 12U);
}

TEST(VelodyneCapture, PacketsThatNameAnotherProductAreDecodedWhenTheirPeriodIsTheModels) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vlp16_2014_says_hdl32.pcap");
  const Decoded decoded = decode_all(path);
  EXPECT_EQ(decoded.counters.lying_packets, 84U);
}

TEST(VelodyneCapture, PacketsOfAnotherModelAreRefusedByName) {
  for (const char* name : {"hdl32e_2011_port443.pcap", "vlp32c_fov_379.pcap", "vls128_strongest_2193.pcap"}) {
    LIDARD_NEED_CAPTURE(path, std::string("velodyne/") + name);
    const Decoded decoded = decode_all(path);
    EXPECT_EQ(decoded.output.rows.size(), 0U) << name;
    EXPECT_GE(decoded.counters.rejected_total() + 1, decoded.counters.packets) << name;
  }
}

/// The returns of a capture, order aside.
std::vector<std::tuple<std::int64_t, int, int, long, long, long>> returns_of(const Decoded& decoded) {
  std::vector<std::tuple<std::int64_t, int, int, long, long, long>> all;
  for (const Row& r : decoded.output.rows) {
    all.emplace_back(r.offset_ns, r.laser, r.echo, std::lround(r.distance_m / 0.002),
                     std::lround(r.intensity), std::lround(r.azimuth_deg * 1e5));
  }
  std::sort(all.begin(), all.end());
  return all;
}

TEST(VelodyneCapture, EveryLegalRelativeDecodesToTheSameReturns) {
  LIDARD_NEED_CAPTURE(plain_path, "velodyne/vlp16_2014_says_hdl32.pcap");
  const auto plain = returns_of(decode_all(plain_path));
  ASSERT_EQ(plain.size(), 19579U);
  for (const char* name : {"nsec.pcap",
                           "swapped.pcap",
                           "swapped_nsec.pcap",
                           "vlan.pcap",
                           "qinq.pcap",
                           "sll.pcap",
                           "sll2.pcap",
                           "raw.pcap",
                           "raw12.pcap",
                           "null.pcap",
                           "loop.pcap",
                           "ipopts.pcap",
                           "pad.pcap",
                           "nochecksum.pcap",
                           "ipv6.pcap",
                           "frag.pcap",
                           "frag_reorder.pcap",
                           "frag_dup.pcap",
                           "pcapng_le.pcapng",
                           "pcapng_be.pcapng",
                           "pcapng_nsec.pcapng",
                           "pcapng_two_if.pcapng",
                           "pcapng_two_eth.pcapng",
                           "noise.pcap",
                           "hourwrap.pcap",
                           "swap8.pcap",
                           "dup8.pcap"}) {
    LIDARD_NEED_CAPTURE(path, std::string("odd/") + name);
    const Decoded decoded = decode_all(path);
    EXPECT_EQ(returns_of(decoded), plain) << name;
    EXPECT_EQ(decoded.capture_error, "") << name;
    const auto duplicates = decoded.counters.rejected[static_cast<std::size_t>(Reject::duplicate)];
    EXPECT_EQ(duplicates, std::string(name) == "dup8.pcap" ? 8U : 0U) << name;
    EXPECT_EQ(decoded.counters.reordered, std::string(name) == "swap8.pcap" ? 6U : 0U) << name;
    EXPECT_EQ(decoded.counters.lost_packets, 0U) << name;
    EXPECT_EQ(decoded.output.clouds.size(), 2U) << name;
  }
}

TEST(VelodyneCapture, LostPacketsAreCountedExactly) {
  LIDARD_NEED_CAPTURE(path, "odd/drop10.pcap");
  const Decoded decoded = decode_all(path);
  // Ten of 84 are missing; the last of them is the end of the capture, where nobody can know.
  EXPECT_EQ(decoded.counters.packets, 77U);
  EXPECT_EQ(decoded.counters.lost_packets, 6U);
}

}  // namespace
}  // namespace lidard
