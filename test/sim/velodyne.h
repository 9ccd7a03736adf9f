// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "test/sim/sensor_model.h"

namespace lidard::sim {

enum class ReturnMode : std::uint8_t { strongest, last, dual };

/// One laser of a rotating head.
struct VelodyneLaser {
  double elevation_deg;
  double z_offset_mm;      ///< height where its beam crosses the axis
  std::int64_t firing_ns;  ///< after the begin of its firing sequence
};

/// A product that sends 12 blocks of 32 slots, all with the flag 0xEEFF.
struct VelodyneTable {
  const char* name;
  std::uint8_t product;               ///< byte 1205
  double step_mm;                     ///< of a distance count
  std::int64_t sequence_ns;           ///< from one firing sequence to the next
  std::vector<VelodyneLaser> lasers;  ///< 16 or 32, in firing order
  double range_min, range_max;        ///< m
};

/// VLP-16 and Puck LITE.
const VelodyneTable& vlp16_table();

struct VelodyneOptions {
  ReturnMode mode = ReturnMode::strongest;
  /// Turn during one firing sequence. The default makes all azimuths exact on the wire (602.8 rpm for 16
  /// lasers).
  double sequence_turn_deg = 0.2;
  double start_azimuth_deg = 0;
  double telemetry_hz = 0;  ///< position packets per second; 0 none
  bool pps_locked = false;  ///< what the position packets say
};

/// A device of that product.
ModelMaker make_velodyne(const VelodyneTable& table, const VelodyneOptions& options);

/// The sentence a GPS receiver sends for that time (UTC), with checksum and line end.
std::string gprmc(Stamp time, bool valid);

}  // namespace lidard::sim
