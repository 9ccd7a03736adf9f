// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/sim/servers/velodyne_stream.h"
#include "test/support/collector.h"

namespace lidard {
namespace {

using sim::SimulatedPacket;
using sim::VelodyneSetup;
using test::Collector;

struct Result {
  Collector output;
  Counters counters;
};

Result decode(const VelodyneSetup& setup, const std::vector<SimulatedPacket>& packets, double cut_deg) {
  DriverConfig config;
  config.model = find_model(setup.model);
  config.clock = ClockMode::arrival;
  config.cut_angle = cut_deg * M_PI / 180;
  config.keep_partial = config.keep_origins = true;
  const auto driver = config.model->make(config);
  Result result;
  const Endpoint sensor{IpAddress::v4(192, 168, 1, 201), 2368};
  for (const auto& packet : packets)
    driver->receive({packet.view(), packet.arrival, sensor, {{}, packet.port}}, result.output);
  driver->finish(result.output);
  result.counters = driver->counters();
  return result;
}

/// Every return on the wire comes out once, at the place and time of the simulator's truth.
void compare(const VelodyneSetup& setup, double cut_deg, double time_limit_s) {
  SCOPED_TRACE(setup.model + " " + setup.mode + " timing " + setup.timing + (setup.fov ? " fov" : "") +
               " cut " + std::to_string(cut_deg));
  const auto packets = simulate_velodyne(setup);
  const Result result = decode(setup, packets, cut_deg);
  EXPECT_EQ(result.counters.rejected_total(), 0U);
  EXPECT_EQ(result.counters.lost_packets, 0U);
  std::size_t expected = 0;
  for (const auto& packet : packets) {
    for (const auto& slot : packet.slots) expected += std::isfinite(slot.wire) ? 1U : 0U;
  }
  EXPECT_GT(expected, 5000U);
  EXPECT_EQ(result.output.rows.size(), expected);
  // Rows are matched by block, laser and distance step; VLP-16 blocks hold each laser twice, so time tells
  // them apart.
  double worst_m = 0;
  double worst_s = 0;
  std::size_t unmatched = 0;
  for (const auto& row : result.output.rows) {
    const SimulatedPacket& packet = packets.at(row.packet);
    const sim::SlotTruth* best = nullptr;
    double best_s = 1;
    for (std::size_t k = 0; k < 32; ++k) {
      const auto& slot = packet.slots.at(static_cast<std::size_t>(row.block) * 32 + k);
      if (slot.laser != row.laser || !std::isfinite(slot.wire)) continue;
      if (std::abs(slot.wire - row.distance_m) > 1e-6) continue;
      // Host stamps of a packet hang on its arrival, which is its last firing and the network's time.
      const double off = std::abs(seconds(Stamp{row.stamp_ns} - slot.time));
      if (off < best_s) best = &slot, best_s = off;
    }
    if (best == nullptr) {
      ++unmatched;
      continue;
    }
    const double radial = row.distance_m / best->exact;
    const Eigen::Vector3d direction = best->xyz / best->xyz.norm();
    // The truth's point, moved along the beam by the wire's rounding.
    const Eigen::Vector3d truth = best->xyz + direction * (best->exact * (radial - 1));
    // A VLS-128's stamps are whole microseconds: its rotation is known to a part in a thousand after some
    // packets.
    constexpr std::uint32_t settling_packets = 20;
    const double off_m = (Eigen::Vector3d(row.x, row.y, row.z) - truth).norm();
    if (row.packet >= settling_packets) worst_m = std::max(worst_m, off_m);
    EXPECT_LT(off_m, 1e-3);
    worst_s = std::max(worst_s, best_s);
  }
  EXPECT_EQ(unmatched, 0U);
  EXPECT_LT(worst_m, 1e-4);
  EXPECT_LT(worst_s, time_limit_s);
}

// Arrivals carry a latency of 20 us and the 7 to 21 us between the last firing and the end of its sequence.
constexpr double arrival_limit_s = 60e-6;

VelodyneSetup setup_of(const char* model, const char* mode) {
  VelodyneSetup setup;
  setup.model = model;
  setup.mode = mode;
  if (setup.mode != "strongest" && setup.mode != "last") setup.divergence_mrad = 3;
  setup.duration = std::chrono::milliseconds(120);
  return setup;
}

TEST(VelodyneTruth, EveryPuckAndHdl32eInEveryModeIsWhereTheSimulatorSaysItIs) {
  for (const char* model : {"velodyne_vlp16", "velodyne_puck_lite", "velodyne_puck_hires", "velodyne_vlp32a",
                            "velodyne_vlp32b", "velodyne_vlp32c", "velodyne_hdl32e"}) {
    for (const char* mode : {"strongest", "last", "dual"}) compare(setup_of(model, mode), 0, arrival_limit_s);
  }
}

TEST(VelodyneTruth, OldHdl32eFirmwareStampsTheEndOfThePacket) {
  VelodyneSetup setup = setup_of("velodyne_hdl32e", "strongest");
  setup.old_stamp = true;
  compare(setup, 0, arrival_limit_s);
}

TEST(VelodyneTruth, Vls128IsRightInEachTimingVariantAndMode) {
  for (const char* timing : {"a", "b", "c"}) {
    for (const char* mode : {"strongest", "dual", "dual_confidence"}) {
      VelodyneSetup setup = setup_of("velodyne_vls128", mode);
      setup.timing = timing;
      setup.rest_spread_us = 0;
      setup.duration = std::chrono::milliseconds(60);
      compare(setup, 0, arrival_limit_s);
    }
  }
}

TEST(VelodyneTruth, Hdl64eIsWhereTheSimulatorSaysItIs) {
  compare(setup_of("velodyne_hdl64e_s1", "strongest"), 0, arrival_limit_s);
  for (const char* model : {"velodyne_hdl64e_s2", "velodyne_hdl64e_s21", "velodyne_hdl64e_s3"}) {
    for (const char* mode : {"strongest", "dual"}) {
      for (const char* timing : {"48", "57.6"}) {
        VelodyneSetup setup = setup_of(model, mode);
        setup.timing = timing;
        compare(setup, 0, arrival_limit_s);
      }
    }
  }
}

TEST(VelodyneTruth, FieldOfViewLeavesNoLossAndRightTimes) {
  for (const char* model : {"velodyne_vlp16", "velodyne_vlp32c", "velodyne_hdl32e"}) {
    for (const double start : {270.0, 10.0}) {
      VelodyneSetup setup = setup_of(model, "strongest");
      setup.fov = sim::AzimuthSector{start, std::fmod(start + 140.1, 360)};
      setup.duration = std::chrono::milliseconds(600);
      compare(setup, 180, arrival_limit_s);
    }
  }
}

}  // namespace
}  // namespace lidard
