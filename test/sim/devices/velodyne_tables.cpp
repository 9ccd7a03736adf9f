// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/velodyne_tables.h"

#include <cmath>
#include <stdexcept>
#include <utility>

#include "test/sim/world/motion.h"

namespace lidard::sim {
namespace {

/// Lasers that fire in groups of `together`, group after group.
VelodyneTiming even_timing(std::size_t lasers, std::size_t together, double slot_ns, std::int64_t sequence_ns,
                           double turn_deg) {
  VelodyneTiming timing{"", sequence_ns, {}, turn_deg};
  for (std::size_t i = 0; i < lasers; ++i) {
    timing.firing_ns.push_back(std::llround(static_cast<double>(i / together) * slot_ns));
  }
  return timing;
}

// VLP-16: Velodyne 63-9243 ch. 9.4: one laser every 2.304 us, a sequence every 55.296 us.
std::vector<VelodyneTiming> puck_timing() { return {even_timing(16, 1, 2'304, 55'296, 0.2)}; }
// VLP-32C: Velodyne 63-9325 ch. 9.4: pairs. VLP-32A and B are assumed to be equal (unverified).
std::vector<VelodyneTiming> ultra_puck_timing() { return {even_timing(32, 2, 2'304, 55'296, 0.2)}; }
// HDL-32E: Velodyne application note 63-9277: singly.
std::vector<VelodyneTiming> hdl32e_timing() { return {even_timing(32, 1, 1'152, 46'080, 0.16)}; }

/// HDL-64E: laser k of the upper and of the lower block fire together, in eight groups of four.
VelodyneTiming hdl64e_timing(std::string name, std::int64_t group_ns, std::vector<std::int64_t> within_ns,
                             double turn_deg) {
  VelodyneTiming timing{std::move(name), 8 * group_ns, {}, turn_deg};
  for (std::size_t i = 0; i < 64; ++i) {
    const std::size_t k = i % 32;
    timing.firing_ns.push_back(static_cast<std::int64_t>(k / 4) * group_ns + within_ns[k % 4]);
  }
  return timing;
}

// velodyne_decoder's tables for S2 and S3 (unverified on recordings).
VelodyneTiming column_48() { return hdl64e_timing("48", 6'000, {0, 1'260, 2'460, 3'660}, 0.17); }
VelodyneTiming column_57_6() { return hdl64e_timing("57.6", 7'200, {0, 1'300, 2'500, 3'700}, 0.2); }

/// S1: from the capture of one (chalmers-revere/opendlv.core, atwallshort.pcap): 12 blocks of 32.0 us each,
/// at even steps of the azimuth also from packet to packet. That the lasers of a block fire one after another
/// and evenly is unverified. The default turn is two steps of the encoder for each block.
VelodyneTiming hdl64e_s1_timing() {
  constexpr std::int64_t block_ns = 32'000;
  VelodyneTiming timing{"", block_ns, {}, 2 * encoder_step_deg};
  for (std::size_t i = 0; i < 64; ++i)
    timing.firing_ns.push_back(block_ns / 32 * static_cast<std::int64_t>(i % 32));
  return timing;
}

/// VLS-128: groups of eight; `pause` slots of silence after the eighth group and after the last.
VelodyneTiming vls128_timing(const char* name, double slot_ns, std::size_t pause, std::int64_t sequence_ns,
                             double turn_deg) {
  VelodyneTiming timing{name, sequence_ns, {}, turn_deg};
  for (std::size_t i = 0; i < 128; ++i) {
    timing.firing_ns.push_back(std::llround(static_cast<double>(i / 8 + pause * (i / 64)) * slot_ns));
  }
  return timing;
}

// a: Velodyne 63-9483 draft Rev A. b: its Rev 3 (firmware 5.1.7.1), which only other drivers cite; 165.8 us
// per packet were measured. c: its Rev 4 (from 5.2.3), as velodyne_decoder has it (unverified).
std::vector<VelodyneTiming> vls128_timings() {
  VelodyneTiming a = vls128_timing("a", 2'665, 1, 53'300, 0.2);
  a.stamp_lag_ns = 8'700;
  VelodyneTiming b = vls128_timing("b", 8'000.0 / 3, 2, 53'333, 0.2);
  b.stamp_lag_ns = 7'000;
  b.rest_ns = 1'941;
  VelodyneTiming c = vls128_timing("c", 2'890, 2, 57'800, 0.2);
  c.stamp_lag_ns = 7'000;
  return {b, a, c};
}

// All beams of the VLP-32 cross 42.4 mm in front of the axis, those of the VLS-128 58.63 mm
// (velodyne_decoder; the first agrees with the floor of a recording, the second is the likeliest:
// drivers/velodyne/models.cpp).
VelodyneLasers raised(VelodyneLasers lasers) {
  const double focal_mm = lasers.size() == 128 ? 58.63 : 42.4;
  for (VelodyneLaser& laser : lasers) {
    laser.z_offset_mm = focal_mm * std::tan(-laser.elevation_deg * rad_per_deg);
  }
  return lasers;
}

std::vector<VelodyneTable> make_tables() {
  using Telemetry = VelodyneTelemetry;
  const auto plain = Telemetry::plain;
  const auto warm = Telemetry::temperatures;
  // Product bytes: Velodyne 63-9243 table 9-3; 0x23, 0x28 and 0xA1 as velodyne_decoder and VeloView have
  // them.
  return {
      {"velodyne_vlp16", 0x22, 2, 100, true, plain, vlp16_lasers(), puck_timing()},
      {"velodyne_puck_lite", 0x22, 2, 100, true, plain, vlp16_lasers(), puck_timing()},
      {"velodyne_puck_hires", 0x24, 2, 100, true, plain, puck_hires_lasers(), puck_timing()},
      {"velodyne_vlp32a", 0x23, 4, 200, true, plain, raised(vlp32a_lasers()), ultra_puck_timing()},
      {"velodyne_vlp32b", 0x23, 4, 200, true, plain, raised(vlp32c_lasers()), ultra_puck_timing()},
      {"velodyne_vlp32c", 0x28, 4, 200, true, warm, raised(vlp32c_lasers()), ultra_puck_timing()},
      {"velodyne_hdl32e", 0x21, 2, 100, true, Telemetry::inertial, hdl32e_lasers(), hdl32e_timing()},
      {"velodyne_hdl64e_s1", 0, 2, 120, false, plain, hdl64e_utexas_lasers(), {hdl64e_s1_timing()}, true},
      {"velodyne_hdl64e_s2", 0, 2, 120, true, plain, hdl64e_utexas_lasers(), {column_48(), column_57_6()}},
      {"velodyne_hdl64e_s21", 0, 2, 120, true, plain, hdl64e_sztaki_lasers(), {column_48(), column_57_6()}},
      {"velodyne_hdl64e_s3", 0, 2, 120, true, plain, hdl64e_xiesc_lasers(), {column_57_6(), column_48()}},
      {"velodyne_vls128", 0xa1, 4, 245, true, warm, raised(vls128_lasers()), vls128_timings()},
      {"velodyne_alpha_prime", 0xa1, 4, 245, true, warm, raised(vls128_lasers()), vls128_timings()},
  };
}

}  // namespace

const std::vector<VelodyneTable>& velodyne_tables() {
  static const std::vector<VelodyneTable> tables = make_tables();
  return tables;
}

const VelodyneTable& velodyne_table(const std::string& name) {
  for (const VelodyneTable& table : velodyne_tables()) {
    if (table.name == name) return table;
  }
  throw std::invalid_argument("the simulator has no Velodyne named '" + name +
                              "'; expected e.g. velodyne_vlp16");
}

}  // namespace lidard::sim
