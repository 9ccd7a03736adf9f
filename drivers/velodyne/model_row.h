// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/time.h"

namespace lidard::velodyne {

/// One laser's geometry, as in the manuals (sensor frame: +Y front, azimuth clockwise).
struct Laser {
  double elevation_deg;
  double rot_correction_deg;  ///< subtracted from the azimuth
  double z_offset_mm;         ///< added to z: where the beam leaves the axis
};

/// What the data packet of one model means: its lasers and when each of them fires.
struct ModelRow {
  std::string_view product;
  std::uint8_t product_id;  ///< last byte of the packet
  double distance_step_m;
  std::size_t lasers;  ///< slots of one firing sequence; a divisor or multiple of the 32 slots of a block
  std::size_t lasers_together;  ///< lasers that fire at the same instant
  Span slot_time;               ///< from one instant of a sequence to the next
  Span sequence_time;           ///< from one firing sequence to the next
  const Laser* laser;           ///< [lasers]

  std::size_t sequences_per_block() const { return 32 / lasers; }
  /// Firing time of a laser after the begin of its sequence.
  Span firing_time(std::size_t index) const { return slot_time * static_cast<int>(index / lasers_together); }
  /// Time from packet to packet in single (`echoes` 1) or dual return mode (2).
  Span packet_period(std::size_t echoes) const {
    return sequence_time * static_cast<int>(12 / echoes * sequences_per_block());
  }
};

/// Ring of each laser: its place in ascending order of elevation, equal elevations in order of the laser's
/// number.
std::vector<std::uint16_t> rings_by_elevation(const ModelRow& row);

/// All rows, for recognition.
const std::vector<const ModelRow*>& model_rows();
/// "HDL-32E" for a product byte of any Velodyne, also of those without a row; "unknown product 0x.."
/// otherwise.
std::string product_name(std::uint8_t product_id);

}  // namespace lidard::velodyne
