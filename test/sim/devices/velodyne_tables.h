// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace lidard::sim {

/// Of the azimuths of an HDL-64E S1: those of its capture are multiples of it, 4000 in a turn.
constexpr double encoder_step_deg = 0.09;

/// One laser of a rotating head: where its beam goes when the head's azimuth is 0.
struct VelodyneLaser {
  double elevation_deg = 0;
  double rot_correction_deg = 0;  ///< subtracted from the head's azimuth
  double z_offset_mm = 0;         ///< height where its beam crosses the axis
};
using VelodyneLasers = std::vector<VelodyneLaser>;

VelodyneLasers vlp16_lasers();
VelodyneLasers puck_hires_lasers();
VelodyneLasers vlp32a_lasers();
VelodyneLasers vlp32c_lasers();
VelodyneLasers hdl32e_lasers();
VelodyneLasers hdl64e_utexas_lasers();
VelodyneLasers hdl64e_sztaki_lasers();
VelodyneLasers hdl64e_xiesc_lasers();
VelodyneLasers vls128_lasers();

/// When the lasers of a head fire. ns.
struct VelodyneTiming {
  std::string name;                     ///< empty where a product has only one
  std::int64_t sequence_ns;             ///< from one firing sequence to the next, without rest
  std::vector<std::int64_t> firing_ns;  ///< [lasers] after the begin of their sequence
  double turn_deg;  ///< default turn per sequence (rest included): azimuths are exact on the wire
  std::int64_t stamp_lag_ns = 0;  ///< the packet's stamp minus its first firing
  std::int64_t rest_ns = 0;       ///< mean of the random rest after each sequence

  std::int64_t period_ns() const { return sequence_ns + rest_ns; }
};

/// What a position packet holds beside time, PPS state and NMEA sentence.
enum class VelodyneTelemetry : std::uint8_t { plain, inertial, temperatures };

/// A product: every spinning Velodyne sends 12 blocks of 32 slots; lasers beyond the 32nd have blocks of
/// their own flags.
struct VelodyneTable {
  const char* name;
  std::uint8_t product;  ///< byte 1205; 0: that place holds something else (HDL-64E)
  double step_mm;        ///< of a distance count
  double range_max;      ///< m
  bool has_dual;
  VelodyneTelemetry telemetry;
  VelodyneLasers lasers;                ///< by the device's number
  std::vector<VelodyneTiming> timings;  ///< the first is the default
  /// HDL-64E S1: a firing sequence is one bank's, its azimuth is where the head's encoder was when it began,
  /// and the packet ends with text instead of a stamp.
  bool bank_by_bank = false;

  /// Lasers that fire in a sequence.
  std::size_t lasers_per_sequence() const { return bank_by_bank ? 32 : lasers.size(); }
  /// HDL-64E from S2: a status byte per packet instead of mode and product.
  bool has_status() const { return lasers.size() == 64 && !bank_by_bank; }
  /// VLS-128: a return mode of its own with a confidence word per pair of returns.
  bool has_confidence() const { return lasers.size() == 128; }
};

/// All products.
const std::vector<VelodyneTable>& velodyne_tables();
/// The product of that name; throws std::invalid_argument.
const VelodyneTable& velodyne_table(const std::string& name);

}  // namespace lidard::sim
