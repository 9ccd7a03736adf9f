// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "drivers/velodyne/calibration.h"
#include "drivers/velodyne/models.h"
#include "test/sim/servers/velodyne_stream.h"
#include "test/support/collector.h"
#include "test/support/velodyne_wire.h"

namespace lidard {
namespace {

using test::Collector;
using test::Columns;
using test::WirePacket;

constexpr std::size_t round_packets = 4160;

std::string detail(const Driver& driver, const std::string& key) {
  for (const auto& [name, value] : driver.info().details) {
    if (name == key) return value;
  }
  return {};
}

DriverConfig config_of(const char* model) {
  DriverConfig config;
  config.model = find_model(model);
  config.clock = ClockMode::arrival;
  config.keep_partial = true;
  return config;
}

double worst_error(const Collector& out, const std::vector<sim::SimulatedPacket>& packets, std::uint32_t from,
                   std::uint32_t to) {
  const auto& table = sim::velodyne_table("velodyne_hdl64e_s3");
  double worst = 0;
  std::size_t compared = 0;
  for (const auto& row : out.rows) {
    if (row.packet < from || row.packet >= to) continue;
    const auto& slot =
        packets[row.packet].slots.at(static_cast<std::size_t>(row.block * 32 + row.laser % 32));
    worst = std::max(worst, (Eigen::Vector3d(row.x, row.y, row.z) - wire_point(slot, table)).norm());
    ++compared;
  }
  EXPECT_GT(compared, 1000U);
  return worst;
}

TEST(Hdl64Stream, TheCalibrationThatTheSensorSendsPlacesItsReturnsFromTheNextFrameOn) {
  sim::VelodyneSetup setup;
  setup.model = "velodyne_hdl64e_s3";
  setup.range_max = 3.2;  // some of the poles: enough
  setup.duration = std::chrono::milliseconds(1750);
  const auto packets = simulate_velodyne(setup);
  ASSERT_GT(packets.size(), round_packets + 600);
  // The table of another unit, whose lasers look elsewhere.
  DriverConfig config = config_of("velodyne_hdl64e_s21");
  config.keep_origins = true;
  const auto driver = config.model->make(config);
  Collector out;
  std::uint32_t known_at = 0;
  for (const auto& packet : packets) {
    test::give(*driver, {packet.payload, packet.arrival}, out);
    if (known_at != 0) continue;
    driver->tick(packet.arrival, out);
    if (detail(*driver, "calibration") == "sent by the sensor")
      known_at = static_cast<std::uint32_t>(driver->counters().packets - 1);
    else
      ASSERT_EQ(detail(*driver, "calibration"), "that of another sensor, until the sensor sends its own");
  }
  driver->finish(out);
  EXPECT_EQ(driver->counters().rejected_total(), 0U);
  EXPECT_NEAR(known_at, round_packets, 16) << "when the next round begins as it should";
  std::uint32_t next_frame = 0;
  for (const Cloud& cloud : out.clouds) {
    const std::uint32_t first = cloud.columns.front().packet;
    if (first > known_at && next_frame == 0) next_frame = first;
  }
  ASSERT_GT(next_frame, known_at);
  EXPECT_GT(worst_error(out, packets, 0, next_frame - 1), 0.05);
  EXPECT_LT(worst_error(out, packets, next_frame + 1, static_cast<std::uint32_t>(packets.size())), 1e-4);
}

/// Three rounds of an S2 that sees 8 m everywhere and says that each laser measures 1300 mm too little.
std::vector<WirePacket> corrected_stream() {
  const test::ModelMode s2{"velodyne_hdl64e_s2", sim::ReturnMode::strongest, "48"};
  auto packets = test::spin(s2, 37);
  for (std::size_t i = 0; i < packets.size(); ++i) {
    // 63-HDL64ES3 Rev K, appendix E: seven calibration bytes end each cycle of 16 packets, 28 make a laser's
    // record.
    const std::size_t place = i % 16;
    if (place < 9) continue;
    const std::size_t index = i / 16 % 260 * 7 + place - 9;
    if (index < 7 || index >= 7 + 64 * 28) continue;
    if ((index - 7) % 28 == 5) packets[i].bytes[1205] = 1300 % 256;
    if ((index - 7) % 28 == 6) packets[i].bytes[1205] = 1300 / 256;
  }
  return packets;
}

std::vector<std::size_t> points_per_frame(const DriverConfig& config,
                                          const std::vector<WirePacket>& packets) {
  class Sizes final : public FrameReceiver {
   public:
    void scan(PlanarScan& /*scan*/) override {}
    void cloud(Cloud& cloud) override { sizes.push_back(cloud.size()); }
    std::vector<std::size_t> sizes;
  } out;
  const auto driver = config.model->make(config);
  for (const auto& packet : packets) test::give(*driver, packet, out);
  driver->finish(out);
  EXPECT_EQ(detail(*driver, "calibration"), config.calibration ? "file" : "sent by the sensor");
  EXPECT_EQ(detail(*driver, "series"), "S2");
  EXPECT_EQ(detail(*driver, "firmware_version"), "4.07");
  EXPECT_TRUE(driver->info().warnings.empty());
  return out.sizes;
}

TEST(Hdl64Stream, RangeLimitsAreThoseOfTheCorrectedDistance) {
  const auto packets = corrected_stream();
  ASSERT_GT(packets.size(), 3 * round_packets + 300);
  DriverConfig config = config_of("velodyne_hdl64e_s2");
  config.min_range = 9;
  config.max_range = 9.4;
  const auto sizes = points_per_frame(config, packets);
  ASSERT_GT(sizes.size(), 36U);
  EXPECT_EQ(sizes[1], 0U) << "8 m without the correction";
  EXPECT_GT(sizes.back(), 1000U) << "9.3 m with it";
  config.min_range = 0;
  config.max_range = 9;
  const auto nearer = points_per_frame(config, packets);
  EXPECT_GT(nearer[1], 1000U);
  EXPECT_EQ(nearer.back(), 0U);
}

TEST(Hdl64Stream, ACalibrationFileIsPreferredToWhatTheSensorSends) {
  DriverConfig config = config_of("velodyne_hdl64e_s2");
  Calibration file;
  file.lasers.resize(64);
  config.calibration = std::make_shared<const Calibration>(file);
  const auto packets = corrected_stream();
  // The file corrects nothing: 8 m stay 8 m from the first frame to the last, and nothing comes to be at 9.3
  // m.
  config.min_range = 7.9;
  config.max_range = 8.1;
  const auto uncorrected = points_per_frame(config, packets);
  ASSERT_GT(uncorrected.size(), 36U);
  for (std::size_t i = 1; i + 1 < uncorrected.size(); ++i) EXPECT_GT(uncorrected[i], 1000U) << i;
  config.min_range = 9;
  config.max_range = 9.4;
  const auto corrected = points_per_frame(config, packets);
  ASSERT_EQ(corrected.size(), uncorrected.size());
  for (std::size_t i = 0; i < corrected.size(); ++i) EXPECT_EQ(corrected[i], 0U) << i;
}

TEST(Hdl64Stream, RangeLimitsAreThoseOfEachLasersCorrectedDistance) {
  const test::ModelMode which{"velodyne_vlp16", sim::ReturnMode::strongest, ""};
  DriverConfig config = config_of("velodyne_vlp16");
  Calibration file;
  file.lasers.resize(16);
  for (std::size_t i = 0; i < 16; ++i) {
    file.lasers[i].vert_correction = 0.01 * static_cast<double>(i);
    file.lasers[i].dist_correction = 0.1 * static_cast<double>(i) - 0.7;  // 8 m become 7.3 ... 8.8 m
  }
  config.calibration = std::make_shared<const Calibration>(file);
  config.min_range = 7.4;
  config.max_range = 8.4999;
  config.keep_origins = true;
  const auto driver = config.model->make(config);
  Collector out;
  const auto packets = test::spin(which, 1.1);
  for (const auto& packet : packets) test::give(*driver, packet, out);
  driver->finish(out);
  std::size_t points = 0;
  for (const Cloud& cloud : out.clouds) points += cloud.size();
  EXPECT_EQ(points, out.rows.size());
  EXPECT_EQ(points, packets.size() * 24 * 11) << "lasers 1 to 11";
  for (const auto& row : out.rows) {
    ASSERT_GE(row.distance_m, 7.4 - 1e-9);
    ASSERT_LE(row.distance_m, 8.4999);
  }
}

}  // namespace
}  // namespace lidard
