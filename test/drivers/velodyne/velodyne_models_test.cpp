// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/models.h"
#include "drivers/velodyne/packet.h"
#include "drivers/velodyne/timing.h"
#include "test/support/captures.h"
#include "test/support/collector.h"

namespace lidard {
namespace {

using test::Decoded;
using test::Row;

Decoded decode_as(const std::string& path, const char* model, double cut_deg = 0) {
  DriverConfig config;
  config.cut_angle = cut_deg * M_PI / 180;
  config.clock = ClockMode::arrival;
  config.keep_partial = true;
  config.keep_origins = true;
  return test::decode_capture(path, model, config);
}

struct Published {
  const char* file;
  const char* model;
  double step_m;
  std::size_t returns;
  long counts, intensity;
};

TEST(VelodyneModels, RealCapturesHaveThePublishedSumsAndNoLoss) {
  const std::vector<Published> all = {
      {"hdl32e_2011_port443.pcap", "velodyne_hdl32e", 0.002, 146705, 608683362, 31946115},
      {"vlp32c_fov_379.pcap", "velodyne_vlp32c", 0.004, 131305, 152720164, 6028208},
      {"vls128_strongest_2193.pcap", "velodyne_vls128", 0.004, 765932, 6286984403, 13548279}};
  for (const Published& p : all) {
    LIDARD_NEED_CAPTURE(path, std::string("velodyne/") + p.file);
    const Decoded decoded = decode_as(path, p.model);
    long counts = 0;
    long intensity = 0;
    for (const Row& row : decoded.output.rows) {
      counts += std::lround(row.distance_m / p.step_m);
      intensity += std::lround(row.intensity);
    }
    EXPECT_EQ(decoded.output.rows.size(), p.returns) << p.file;
    EXPECT_EQ(counts, p.counts) << p.file;
    EXPECT_EQ(intensity, p.intensity) << p.file;
    EXPECT_EQ(decoded.counters.rejected_total(), 0U) << p.file;
    EXPECT_EQ(decoded.counters.lost_packets, 0U) << p.file;
  }
}

TEST(VelodyneModels, OtherHdl32eCapturesDecodeWithoutARejectedPacket) {
  for (const char* file : {"hdl32e_named_vlp32.pcap", "hdl32e_gprmc_876.pcap"}) {
    LIDARD_NEED_CAPTURE(path, std::string("velodyne/") + file);
    const Decoded decoded = decode_as(path, "velodyne_hdl32e");
    EXPECT_EQ(decoded.counters.rejected_total(), 0U) << file;
    EXPECT_EQ(decoded.counters.lost_packets, 0U) << file;
    EXPECT_GT(decoded.output.rows.size(), 10000U) << file;
  }
}

TEST(VelodyneModels, Hdl32eHasThePublishedVectors) {
  LIDARD_NEED_CAPTURE(path, "velodyne/hdl32e_2011_port443.pcap");
  const Decoded decoded = decode_as(path, "velodyne_hdl32e");
  struct Golden {
    int block, laser;
    double after_stamp_us, azimuth_deg;
    int count;
    double x, y, z;
  };
  // Packet 3, computed in double precision from the published payloads, independently of this decoder; angles
  // only.
  const std::vector<Golden> vectors = {{0, 0, 0.000, 227.89000, 203, -0.2342, 0.2591, -0.2071},
                                       {1, 7, 54.144, 228.06625, 9262, -12.3255, 13.7208, -1.7207},
                                       {5, 3, 233.856, 228.65125, 482, -0.6307, 0.7166, -0.1342},
                                       {6, 10, 288.000, 228.82750, 267, -0.3212, 0.3672, -0.2172},
                                       {10, 6, 467.712, 229.41250, 241, -0.2802, 0.3271, -0.2163},
                                       {11, 13, 521.856, 229.58875, 9531, -12.3540, 14.5101, -0.4424}};
  const auto& row = *static_cast<const velodyne::ModelRow*>(find_model("velodyne_hdl32e")->row);
  for (const Golden& golden : vectors) {
    bool found = false;
    for (const Row& r : decoded.output.rows) {
      if (r.packet != 3 || r.block != golden.block || r.laser != golden.laser) continue;
      found = true;
      EXPECT_NEAR(static_cast<double>(r.offset_ns), golden.after_stamp_us * 1000, 2);
      EXPECT_NEAR(r.azimuth_deg, golden.azimuth_deg, 0.001);
      EXPECT_NEAR(r.distance_m, golden.count * 0.002, 1e-9);
      EXPECT_NEAR(r.x, golden.x, 1e-4);
      EXPECT_NEAR(r.y, golden.y, 1e-4);
      const auto laser = static_cast<std::size_t>(golden.laser);
      EXPECT_NEAR(r.z, golden.z + row.laser[laser].z_offset_mm * 1e-3, 1e-4);
    }
    EXPECT_TRUE(found) << golden.block;
  }
}

TEST(VelodyneModels, Vls128TimingIsThatWithRandomRestFromAnyPacketOn) {
  LIDARD_NEED_CAPTURE(path, "velodyne/vls128_strongest_2193.pcap");
  const auto& row = *static_cast<const velodyne::ModelRow*>(find_model("velodyne_vls128")->row);
  const Decoded decoded = decode_as(path, "velodyne_vls128");
  // Sequences begin a third of the way to the next stamp apart: 54.6 to 56.1 us where packets follow each
  // other.
  std::size_t checked = 0;
  for (const Cloud& cloud : decoded.output.clouds) {
    for (std::size_t c = 1; c < cloud.columns.size(); ++c) {
      if (cloud.columns[c].packet != cloud.columns[c - 1].packet) continue;
      const double step_us =
          static_cast<double>((cloud.columns[c].stamp - cloud.columns[c - 1].stamp).count()) * 1e-3;
      ASSERT_GT(step_us, 54.5);
      ASSERT_LT(step_us, 56.2);
      ++checked;
    }
  }
  EXPECT_GT(checked, 4000U);
  EXPECT_EQ(row.timings.front().sequence.count(), 55277);
}

TEST(VelodyneModels, TimingVariantIsRightFromTheFirstPairOfPackets) {
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
