// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The innermost loops of decoding, from the slots of a firing sequence to points in the bytes of a
// PointCloud2. Compiled twice, for any processor and for AVX2, with identical results. This header and the
// kernels use only plain arrays, since an inline function of the standard library compiled for AVX2 could be
// linked into the rest of the program.

#include <cstddef>
#include <cstdint>

namespace lidard::velodyne {

/// Of one firing sequence: the VLS-128's.
constexpr std::size_t most_lasers = 128;
constexpr std::size_t most_banks = 4;
/// Of one packet: two in each of its 12 blocks.
constexpr std::size_t most_sequences = 24;
/// Slots are unpacked this many at a time; 16 lasers or 32 slots of a block are whole numbers of it.
constexpr std::size_t lanes = 8;

/// The properties of the lasers, one array per quantity for vector code. m, rad, s.
struct alignas(32) LaserArrays {
  double turning[most_lasers];      ///< rotation time before it fired
  double cos_rot[most_lasers];      ///< of its rot_correction
  double sin_rot[most_lasers];      ///< of its rot_correction
  float cos_shift[most_lasers];     ///< of its azimuth minus the sequence's; see turn_lasers
  float sin_shift[most_lasers];     ///< of its azimuth minus the sequence's
  float ground_step[most_lasers];   ///< distance over ground of one count
  float ground_begin[most_lasers];  ///< distance over ground of count 0
  float up_step[most_lasers];       ///< height of one count
  float up_begin[most_lasers];      ///< height of count 0
  float time[most_lasers];          ///< its firing after the sequence's first
  std::uint64_t ring[most_lasers];
  std::int32_t nearest[most_lasers];   ///< smallest count of a return
  std::int32_t farthest[most_lasers];  ///< largest count of a return
  std::size_t size;                    ///< number of lasers, a multiple of `lanes`
  std::size_t banks;                   ///< of a sequence, with equal numbers of lasers
};

/// Terms of a sensor's own calibration; see CalibratedGeometry for the names and equations. m, rad. Float is
/// precise enough for the small corrections.
struct alignas(32) CalibrationArrays {
  float dist_correction[most_lasers];
  float cos_vert[most_lasers];
  float sin_vert[most_lasers];
  float r_offset[most_lasers];
  float z_offset[most_lasers];
  float horiz_offset[most_lasers];
  float near_x[most_lasers];  ///< 0 without two-point correction
  float near_y[most_lasers];  ///< 0 without two-point correction
  float focal[most_lasers];
  float focal_slope[most_lasers];
  float min_intensity[most_lasers];
  float max_intensity[most_lasers];
  float step;             ///< one count
  float two_point_below;  ///< the near corrections apply to shorter distances
  float far_target;
};

/// The firing sequences of a packet: slots, directions and times.
struct alignas(32) SequenceArrays {
  double azimuth_deg[most_sequences];                   ///< at the first firing, in (-360, 360)
  double cosine[most_sequences], sine[most_sequences];  ///< of it
  float begin[most_sequences];                          ///< s after the frame's stamp
  /// The first slot of each bank; 8 bytes after the last slot must be readable.
  const std::uint8_t* slots[most_sequences][most_banks];
  std::uint8_t* end[most_sequences];  ///< output: end of the sequence's points
  std::size_t size;
};

/// Cosine and sine of an angle.
struct Direction {
  double cosine, sine;
};
/// The directions of all integer degrees from -360 to 360.
constexpr int whole_turn_deg = 360;
using WholeDegrees = Direction[2 * whole_turn_deg + 1];

/// PointCloud2 bytes of a point: CloudPoint.
constexpr std::size_t point_step = 22;
/// Kernels write up to this many bytes beyond the last point.
constexpr std::size_t overshoot = 2 * point_step;

/// The loops for one kind of processor.
struct SequenceKernels {
  /// Turns the lasers by the rotation (rad/s) since the sequence's first firing, which must be below 0.1 rad
  /// for nine digits.
  void (*turn_lasers)(LaserArrays& lasers, double rate);
  /// Fills in cosines and sines, to 1e-15.
  void (*find_directions)(const WholeDegrees& whole, SequenceArrays& sequences);
  /// Writes the returns of sequences to `out`. Needs find_directions().
  void (*transform)(const LaserArrays& lasers, SequenceArrays& sequences, std::uint8_t* out);
  /// Writes the returns of sequences with all terms of a calibration.
  void (*transform_calibrated)(const LaserArrays& lasers, const CalibrationArrays& calibration,
                               SequenceArrays& sequences, std::uint8_t* out);
};

/// For any processor.
const SequenceKernels& portable_kernels();
/// For processors with AVX2; nullptr if the program's architecture has none.
const SequenceKernels* avx2_kernels();
/// The fastest kernels for this processor.
const SequenceKernels& best_kernels();

}  // namespace lidard::velodyne
