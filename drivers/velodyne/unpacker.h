// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/cloud.h"
#include "drivers/velodyne/model_row.h"

namespace lidard::velodyne {

/// A firing sequence ready to be unpacked.
struct Sequence {
  const std::uint8_t* slots;  ///< the first laser's slot in the packet
  double azimuth_deg;         ///< of its first firing, as the sensor counts it
  Span in_packet;             ///< its begin after the packet's stamp
  Span in_frame;              ///< its begin after the frame's stamp
  Stamp stamp;                ///< its begin on the host's time scale
  std::uint32_t packet;
  std::uint8_t block;
  std::uint8_t echo;
};

/// Turns the slots of firing sequences into points, straight into the cloud's message bytes.
class Unpacker {
 public:
  explicit Unpacker(const ModelRow& row, bool keep_origins);

  /// The rotation during the coming sequences, degrees per second.
  void set_rate(double deg_per_s);
  /// Makes room for one more packet; call before its sequences.
  void reserve_packet(Cloud& cloud) const;
  /// Appends the sequence's returns and its column. Points beyond the capacity made by reserve_packet() are a
  /// bug.
  void append(const Sequence& sequence, Cloud& cloud, std::size_t& points) const;

 private:
  struct LaserTable {
    float cos_elevation, sin_elevation, z_offset;
    float cos_shift, sin_shift;  // of the azimuth between the sequence's begin and this laser's beam
    float time;
    double shift_deg;
    Span firing;
    std::uint16_t ring;
  };
  void append_origins(const Sequence& sequence, Cloud& cloud) const;

  const ModelRow& row_;
  bool keep_origins_;
  double rate_ = 0;
  std::vector<LaserTable> lasers_;
};

}  // namespace lidard::velodyne
