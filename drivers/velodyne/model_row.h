// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "core/base/time.h"

namespace lidard::velodyne {

/// One laser's geometry, as in the manuals (sensor frame: +Y front, azimuth clockwise).
struct Laser {
  double elevation_deg;
  double rot_correction_deg;  ///< subtracted from the azimuth
  double z_offset_mm;         ///< added to z: where the beam leaves the axis
};

/// Firing times of the lasers of a firing sequence, for one firmware.
struct Timing {
  Span sequence;                ///< from one firing sequence to the next, random rest included
  Span step;                    ///< from one firing instant of a sequence to the next
  std::size_t together;         ///< lasers that fire at the same instant
  std::size_t pause_after = 0;  ///< lasers before the pause inside a sequence; 0: no pause
  Span pause{0};
  std::array<Span, 4> within{};  ///< of the lasers of a group of four (HDL-64E)
  Span before{0};                ///< the first firing is this long before the packet's stamp
};

/// The properties of a model's data packet: its lasers and their firing times.
struct ModelRow {
  std::string_view product;
  std::array<std::uint8_t, 2> product_ids;  ///< last byte of the packet; 0: none
  double distance_step_m;
  std::size_t lasers;  ///< of one firing sequence
  std::size_t
      banks;         ///< blocks that hold one firing sequence (1, 2, 4); flags 0xEEFF, 0xDDFF, 0xCCFF, 0xBBFF
  bool random_rest;  ///< a random pause after sequences: their begin follows from the next packet's stamp
  std::vector<Timing>
      timings;  ///< firmware variants, distinguished by the packet period; the usual one first
  const Timing* without_factory_bytes;  ///< timing of old firmware without the last two bytes; nullptr none
  const Laser* laser;                   ///< [lasers]
  /// HDL-64E S1: a block is a firing sequence of one bank, its azimuth holds for all lasers, and the packet
  /// has no stamp.
  bool bank_by_bank = false;
  bool warns = false;  ///< HDL-64E S3: warning bytes are among its status bytes

  bool has_product(std::uint8_t id) const {
    return id != 0 && (id == product_ids[0] || id == product_ids[1]);
  }
  bool names_product() const { return product_ids[0] != 0; }
  bool has_stamp() const { return !bank_by_bank; }
  /// HDL-64E S2 and later: the last two bytes hold the device's state and calibration.
  bool has_status() const { return !names_product() && has_stamp(); }
  std::size_t sequences_per_block() const { return banks == 1 ? 32 / lasers : 1; }
  /// Sequences of a packet in single (`echoes` 1) or dual return mode (2).
  std::size_t sequences_per_packet(std::size_t echoes) const {
    return 12 / ((bank_by_bank ? 1 : banks) * echoes) * sequences_per_block();
  }
  /// Firing time of a laser after the packet's stamp, for the first sequence of the packet.
  Span firing_time(const Timing& timing, std::size_t index) const;
  /// Time from packet to packet.
  Span packet_period(const Timing& timing, std::size_t echoes) const {
    return timing.sequence * static_cast<int>(sequences_per_packet(echoes));
  }
};

/// All rows, for recognition: the first of several equal matches counts.
const std::vector<const ModelRow*>& model_rows();

}  // namespace lidard::velodyne
