// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/cloud.h"
#include "drivers/velodyne/calibration.h"
#include "drivers/velodyne/model_row.h"

namespace lidard::velodyne {

/// A firing sequence ready to be unpacked.
struct Sequence {
  std::array<const std::uint8_t*, 4> slots;  ///< the first slot of each bank in the packet
  double azimuth_deg;                        ///< at its begin, as the sensor counts it
  Span in_packet;                            ///< its begin after the packet's stamp
  Span in_frame;                             ///< its begin after the frame's stamp
  Stamp stamp;                               ///< its begin on the host's time scale
  std::uint32_t packet;
  std::array<std::uint8_t, 4> blocks;  ///< of the banks
  std::uint8_t echo;
};

/// Turns the slots of firing sequences into points, straight into the cloud's message bytes.
class Unpacker {
 public:
  /// Distances (m, with the far correction of a calibration) outside [min_range, max_range] are left out;
  /// max_range 0: no limit. `calibration`: of this very sensor, instead of the model's table; nullptr none.
  Unpacker(const ModelRow& row, bool keep_origins, double min_range, double max_range,
           const Calibration* calibration);

  void set_timing(const Timing& timing);
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
    float cos_rot, sin_rot;      // of the fixed part of it
    float time;                  // of the beam after the sequence's begin by the stamp
    float turning;               // after the sequence's first firing
    std::uint16_t ring;
  };
  struct LaserOrigin {
    double turning_s, rot_deg, shift_deg, cos_turn, sin_turn;
    Span firing;
    std::uint16_t nearest, farthest;  // distance counts within the limits, the laser's correction applied
  };
  bool is_return(std::uint16_t count) const { return static_cast<std::uint16_t>(count - nearest_) <= span_; }
  static bool is_return(const LaserOrigin& laser, std::uint16_t count) {
    return count >= laser.nearest && count <= laser.farthest;
  }
  void set_limits(double min_range, double max_range, double step);
  void append_calibrated(const Sequence& sequence, Cloud& cloud, std::size_t& points) const;
  void append_origins(const Sequence& sequence, Cloud& cloud) const;

  const ModelRow& row_;
  bool keep_origins_;
  std::uint16_t nearest_, span_;  // of distance counts
  double rate_ = 0;
  std::vector<LaserTable> lasers_;
  std::vector<LaserOrigin> origins_;
  std::optional<CalibratedGeometry> geometry_;
};

}  // namespace lidard::velodyne
