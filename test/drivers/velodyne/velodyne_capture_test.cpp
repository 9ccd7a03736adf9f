// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/models.h"
#include "drivers/velodyne/timing.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard {
namespace {

using test::Decoded;
using test::Row;

Decoded decode_as(const std::string& path, const char* model) {
  DriverConfig config;
  config.clock = ClockMode::arrival;
  config.keep_partial = true;
  config.keep_origins = true;
  return test::decode_capture(path, model, config);
}
Decoded decode_all(const std::string& path) { return decode_as(path, "velodyne_vlp16"); }

/// What its publisher's tests say of a recording; returns 0: they do not count them.
struct Captured {
  const char* name;
  const char* model;
  std::size_t datagrams, returns = 0;
  long counts = 0, intensity = 0;
};

TEST(VelodyneCapture, RecordingsHaveThePublishedSumsAndNoRejectedPacket) {
  for (const Captured& published :
       {Captured{"vlp16_gps_293", "velodyne_vlp16", 350, 73486, 47738942, 3548881},
        Captured{"vlp16_dual_603", "velodyne_vlp16", 603, 116827, 167544123, 4881504},
        Captured{"hdl32e_2011_port443", "velodyne_hdl32e", 500, 146705, 608683362, 31946115},
        Captured{"vlp32c_fov_379", "velodyne_vlp32c", 379, 131305, 152720164, 6028208},
        Captured{"vls128_strongest_2193", "velodyne_vls128", 2193, 765932, 6286984403, 13548279},
        Captured{"vlp16_2014_says_hdl32", "velodyne_vlp16", 100},
        Captured{"vlp16_strongest_84", "velodyne_vlp16", 84},
        Captured{"vlp16_strongest_1000", "velodyne_vlp16", 1000},
        Captured{"vlp16_last_1500", "velodyne_vlp16", 1500},
        Captured{"hdl32e_named_vlp32", "velodyne_hdl32e", 100},
        Captured{"hdl32e_gprmc_876", "velodyne_hdl32e", 976}}) {
    SCOPED_TRACE(published.name);
    LIDARD_NEED_CAPTURE(path, std::string("velodyne/") + published.name + ".pcap");
    const Decoded decoded = decode_as(path, published.model);
    EXPECT_EQ(decoded.counters.packets + decoded.counters.other_packets, published.datagrams);
    EXPECT_EQ(decoded.counters.rejected_total(), 0U);
    if (std::string(published.name) != "vlp16_dual_603") {
      EXPECT_EQ(decoded.counters.lost_packets, 0U);
    }
    for (std::size_t f = 1; f < decoded.output.clouds.size(); ++f)
      EXPECT_GT(decoded.output.clouds[f].stamp, decoded.output.clouds[f - 1].stamp);
    EXPECT_GT(decoded.output.rows.size(), 10000U);
    if (published.returns == 0) continue;
    const double step_m =
        static_cast<const velodyne::ModelRow*>(find_model(published.model)->row)->distance_step_m;
    long counts = 0, intensity = 0;
    for (const Row& row : decoded.output.rows) {
      counts += std::lround(row.distance_m / step_m);
      intensity += std::lround(row.intensity);
    }
    EXPECT_EQ(decoded.output.rows.size(), published.returns);
    EXPECT_EQ(counts, published.counts);
    EXPECT_EQ(intensity, published.intensity);
  }
}

/// A return of a recording, computed in double precision from the published payloads, independently of this
/// decoder. The vector comes from the angles alone; the beam's height on the axis is the manual's vertical
/// correction.
struct Vector {
  unsigned packet;
  int block, laser;
  double after_stamp_us, azimuth_deg;
  int count;  // of 2 mm
  double x, y, z;
};

void expect_vectors(const char* file, const char* model, const std::vector<Vector>& vectors) {
  LIDARD_NEED_CAPTURE(path, file);
  const Decoded decoded = decode_as(path, model);
  const auto& table = *static_cast<const velodyne::ModelRow*>(find_model(model)->row);
  for (const Vector& v : vectors) {
    const auto found =
        std::find_if(decoded.output.rows.begin(), decoded.output.rows.end(), [&](const Row& row) {
          return row.packet == v.packet && row.block == v.block && row.laser == v.laser &&
                 std::abs(row.offset_ns - std::llround(v.after_stamp_us * 1000)) <= 2;
        });
    ASSERT_NE(found, decoded.output.rows.end())
        << file << ": " << v.packet << "/" << v.block << "/" << v.laser;
    EXPECT_NEAR(found->azimuth_deg, v.azimuth_deg, 0.001);
    EXPECT_NEAR(found->distance_m, v.count * 0.002, 1e-9);
    EXPECT_NEAR(found->x, v.x, 1e-4);
    EXPECT_NEAR(found->y, v.y, 1e-4);
    EXPECT_NEAR(found->z, v.z + table.laser[v.laser].z_offset_mm * 1e-3, 1e-4);
  }
}

TEST(VelodyneCapture, RecordingsHaveThePublishedVectors) {
  expect_vectors("velodyne/vlp16_gps_293.pcap", "velodyne_vlp16",
                 {{3, 0, 1, 2.304, 133.21830, 845, -1.1571, -1.2314, 0.0295},
                  {3, 1, 7, 126.720, 133.64807, 851, -1.1660, -1.2224, 0.2074},
                  {3, 5, 3, 559.872, 135.22489, 889, -1.2604, -1.2506, 0.0931},
                  {3, 6, 10, 686.592, 135.67295, 900, -1.2828, -1.2530, -0.1569},
                  {3, 10, 7, 1122.048, 137.23807, 926, -1.3496, -1.2480, 0.2257},
                  {3, 11, 13, 1246.464, 137.69784, 948, -1.3664, -1.2434, 0.4265}});
  expect_vectors("velodyne/vlp16_dual_603.pcap", "velodyne_vlp16",
                 {{100, 0, 1, 2.304, 239.66833, 1290, -1.3027, 2.2265, 0.0450},
                  {100, 1, 7, 16.128, 239.71833, 4143, -4.1471, 7.1021, 1.0098},
                  {100, 5, 5, 232.704, 240.50167, 1931, -1.8944, 3.3486, 0.3366},
                  {100, 6, 11, 357.120, 240.95167, 4334, -4.1314, 7.4384, 1.6539},
                  {100, 10, 7, 569.088, 241.71833, 1915, -1.8012, 3.3477, 0.4668},
                  {100, 11, 13, 582.912, 241.76833, 4724, -4.3547, 8.1107, 2.1253}});
  expect_vectors("velodyne/hdl32e_2011_port443.pcap", "velodyne_hdl32e",
                 {{3, 0, 0, 0.000, 227.89000, 203, -0.2342, 0.2591, -0.2071},
                  {3, 1, 7, 54.144, 228.06625, 9262, -12.3255, 13.7208, -1.7207},
                  {3, 5, 3, 233.856, 228.65125, 482, -0.6307, 0.7166, -0.1342},
                  {3, 6, 10, 288.000, 228.82750, 267, -0.3212, 0.3672, -0.2172},
                  {3, 10, 6, 467.712, 229.41250, 241, -0.2802, 0.3271, -0.2163},
                  {3, 11, 13, 521.856, 229.58875, 9531, -12.3540, 14.5101, -0.4424}});
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
  EXPECT_EQ(decoded.counters.wrong_product, 84U);
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

// Relatives whose payloads are those of the plain capture (OddCaptures) decode as that one does.
TEST(VelodyneCapture, RelativesWithOtherPacketsOrStampsDecodeToTheSameReturns) {
  LIDARD_NEED_CAPTURE(plain_path, "velodyne/vlp16_2014_says_hdl32.pcap");
  const auto plain = returns_of(decode_all(plain_path));
  ASSERT_EQ(plain.size(), 19579U);
  for (const char* name : {"noise.pcap", "hourwrap.pcap", "swap8.pcap", "dup8.pcap"}) {
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

TEST(VelodyneTiming, VariantOfAVls128IsRightFromTheFirstPairOfPackets) {
  const auto& row = *static_cast<const velodyne::ModelRow*>(find_model("velodyne_vls128")->row);
  for (const int period : {160, 164, 166, 168, 173, 174}) {
    velodyne::TimingChooser chooser(row);
    chooser.add(std::chrono::microseconds(period), 3);
    const auto expected = period == 160 ? 53300 : period < 170 ? 55277 : 57800;
    EXPECT_EQ(chooser.timing().sequence.count(), expected) << period;
  }
}

}  // namespace
}  // namespace lidard
