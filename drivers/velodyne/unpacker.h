// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/frames/cloud.h"
#include "drivers/velodyne/calibration.h"
#include "drivers/velodyne/models.h"
#include "drivers/velodyne/sequence_kernel.h"

namespace lidard::velodyne {

/// A firing sequence ready to be unpacked.
struct Sequence {
  std::array<const std::uint8_t*, most_banks> slots;  ///< the first slot of each bank in the packet
  double azimuth_deg;                                 ///< at its begin, as the sensor counts it
  Span in_packet;                                     ///< its first firing after the packet's stamp
  Span in_frame;                                      ///< its first firing after the frame's stamp
  Stamp stamp;                                        ///< its first firing on the host's time scale
  std::uint32_t packet;
  std::array<std::uint8_t, most_banks> blocks;  ///< of the banks
  std::uint8_t echo;
};

/// Converts the slots of firing sequences to points in the cloud's message bytes.
class Unpacker {
 public:
  /// Drops distances (m, with the far correction of a calibration) outside [min_range, max_range]; max_range
  /// 0: no limit. `calibration`: the sensor's own, instead of the model's table; nullptr none.
  Unpacker(const ModelRow& row, bool keep_origins, double min_range, double max_range,
           const Calibration* calibration, const SequenceKernels& kernels = best_kernels());

  /// Replaces the calibration for the following sequences.
  void set_calibration(const Calibration& calibration);
  /// Also fills Cloud::too_near.
  void keep_too_near(bool keep) { keep_too_near_ = keep; }
  /// Sets the limits of the following sequences, as in the constructor.
  void set_ranges(double min_range, double max_range) {
    min_range_ = min_range;
    max_range_ = max_range;
    set_limits();
  }
  void set_timing(const Timing& timing);
  /// The rotation during the following sequences, degrees per second.
  void set_rate(double deg_per_s);
  /// Makes room for one more packet; call before its sequences.
  void reserve_packet(Cloud& cloud) const;
  /// Appends the sequence's column; transform() writes its returns. At most one packet's sequences may be
  /// pending.
  void append(const Sequence& sequence, Cloud& cloud);
  /// Writes the returns of the pending sequences after `points` points, within the capacity of
  /// reserve_packet().
  void transform(Cloud& cloud, std::size_t& points);

 private:
  struct LaserOrigin {
    double rot_deg, shift_deg;
    Span firing;  // after the sequence's first firing
  };
  void set_geometry(const Calibration& calibration);
  void set_limits();
  void turn_anew();
  void append_extras(const Sequence& sequence, Cloud& cloud) const;
  void append_origins(const Sequence& sequence, Cloud& cloud) const;
  void append_too_near(const Sequence& sequence, Cloud& cloud) const;

  const ModelRow& row_;
  bool keep_origins_;
  double min_range_, max_range_;
  bool keep_too_near_ = false;
  double rate_ = 0;
  double longest_turning_ = 0;  // s
  const SequenceKernels& kernels_;
  LaserArrays lasers_{};
  std::unique_ptr<CalibrationArrays> calibration_;  // if lasers_ are not enough for a return
  SequenceArrays waiting_{};
  std::vector<LaserOrigin> origins_;
  std::optional<CalibratedGeometry> geometry_;
};

}  // namespace lidard::velodyne
