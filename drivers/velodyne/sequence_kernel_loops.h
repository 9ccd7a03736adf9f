// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Included only by sequence_kernel_any.cpp and sequence_kernel_avx2.cpp, which are compiled for different
// processors. Loops have fixed lengths and no branches, so that the compiler vectorises them.

#include <cstring>

#include "drivers/velodyne/sequence_kernel.h"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace lidard::velodyne {
namespace {

/// `lanes` slots of 3 bytes: distance count (u16 LE), reflectivity (63-9243 Rev D, section 9.3.1.3).
struct alignas(32) Slots {
  std::int32_t count[lanes];
  std::int32_t reflectivity[lanes];
};

/// `lanes` points, returns or not.
struct alignas(32) Points {
  float x[lanes], y[lanes], z[lanes], intensity[lanes], time[lanes];
};

#if defined(__AVX2__)

inline __m256i load(const std::int32_t* from) {
  return _mm256_load_si256(reinterpret_cast<const __m256i*>(from));
}
inline __m128i load_bytes(const std::uint8_t* from) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
}

inline void read_slots(const std::uint8_t* from, Slots& slots) {
  const __m256i spread = _mm256_setr_epi8(0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1,  //
                                          0, 1, 2, -1, 3, 4, 5, -1, 6, 7, 8, -1, 9, 10, 11, -1);
  const __m256i bytes = _mm256_set_m128i(load_bytes(from + 12), load_bytes(from));
  const __m256i words = _mm256_shuffle_epi8(bytes, spread);
  _mm256_store_si256(reinterpret_cast<__m256i*>(slots.count),
                     _mm256_and_si256(words, _mm256_set1_epi32(0xFFFF)));
  _mm256_store_si256(reinterpret_cast<__m256i*>(slots.reflectivity), _mm256_srli_epi32(words, 16));
}

/// Byte offsets of eight points and of their end, by the mask of returns.
struct OffsetTable {
  std::uint8_t at[256][16];
};
constexpr OffsetTable make_offset_table() {
  OffsetTable table{};
  for (unsigned mask = 0; mask < 256; ++mask) {
    unsigned returns = 0;
    for (unsigned k = 0; k < lanes; ++k) {
      table.at[mask][k] = static_cast<std::uint8_t>(returns * point_step);
      returns += mask >> k & 1U;
    }
    table.at[mask][lanes] = static_cast<std::uint8_t>(returns * point_step);
  }
  return table;
}
constexpr OffsetTable offset_table = make_offset_table();

/// Stores a point and bytes after it, which the next point overwrites; overlapping stores are slow.
inline void store(std::uint8_t* to, __m256i xyzi_ring_time) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), xyzi_ring_time);
}
/// Coordinates from `p`, ring and time from `t`; `halves` selects the low or the high half.
template <int halves>
inline __m256i joined(__m256 p, __m256i t) {
  return _mm256_permute2x128_si256(_mm256_castps_si256(p), t, halves);
}
constexpr int low_low = 0x20, low_high = 0x30, high_low = 0x21, high_high = 0x31;

/// Ring (16 bit) and time (32 bit) of four points, each in 8 bytes.
inline __m256i rings_and_times(const std::uint64_t* ring, const float* time) {
  const __m128i times = _mm_load_si128(reinterpret_cast<const __m128i*>(time));
  const __m256i rings = _mm256_load_si256(reinterpret_cast<const __m256i*>(ring));
  return _mm256_or_si256(_mm256_slli_epi64(_mm256_cvtepu32_epi64(times), 16), rings);
}

/// Distance of the prefetch, bytes.
constexpr std::size_t ahead = 2048;

/// Points that are no returns are written, too, and then overwritten: a branch for each costs more.
inline std::uint8_t* write_returns(const LaserArrays& lasers, std::size_t k, const Slots& slots,
                                   const Points& p, std::uint8_t* out) {
  // A large frame is not in the caches when it is written again.
  for (std::size_t line = 0; line < lanes * point_step; line += 64)
    _mm_prefetch(reinterpret_cast<const char*>(out + ahead + line), _MM_HINT_T0);
  const __m256i count = load(slots.count);
  const __m256i none = _mm256_or_si256(_mm256_cmpgt_epi32(load(lasers.nearest + k), count),
                                       _mm256_cmpgt_epi32(count, load(lasers.farthest + k)));
  const int mask = ~_mm256_movemask_ps(_mm256_castsi256_ps(none)) & 0xFF;
  const std::uint8_t* at = offset_table.at[mask];
  const __m256 x = _mm256_load_ps(p.x), y = _mm256_load_ps(p.y);
  const __m256 z = _mm256_load_ps(p.z), intensity = _mm256_load_ps(p.intensity);
  const __m256 xy01 = _mm256_unpacklo_ps(x, y), xy23 = _mm256_unpackhi_ps(x, y);
  const __m256 zi01 = _mm256_unpacklo_ps(z, intensity), zi23 = _mm256_unpackhi_ps(z, intensity);
  const __m256 p04 = _mm256_shuffle_ps(xy01, zi01, 0x44), p15 = _mm256_shuffle_ps(xy01, zi01, 0xEE);
  const __m256 p26 = _mm256_shuffle_ps(xy23, zi23, 0x44), p37 = _mm256_shuffle_ps(xy23, zi23, 0xEE);
  const __m256i low = rings_and_times(lasers.ring + k, p.time);
  const __m256i high = rings_and_times(lasers.ring + k + 4, p.time + 4);
  const __m256i odd_low = _mm256_unpackhi_epi64(low, low), odd_high = _mm256_unpackhi_epi64(high, high);
  store(out + at[0], joined<low_low>(p04, low));
  store(out + at[1], joined<low_low>(p15, odd_low));
  store(out + at[2], joined<low_high>(p26, low));
  store(out + at[3], joined<low_high>(p37, odd_low));
  store(out + at[4], joined<high_low>(p04, high));
  store(out + at[5], joined<high_low>(p15, odd_high));
  store(out + at[6], joined<high_high>(p26, high));
  store(out + at[7], joined<high_high>(p37, odd_high));
  return out + at[lanes];
}

#else

inline void read_slots(const std::uint8_t* from, Slots& slots) {
  for (std::size_t i = 0; i < lanes; ++i) {
    slots.count[i] = from[3 * i] | from[3 * i + 1] << 8;
    slots.reflectivity[i] = from[3 * i + 2];
  }
}

/// Points that are no returns are written, too, and then overwritten: a branch for each costs more.
inline std::uint8_t* write_returns(const LaserArrays& lasers, std::size_t k, const Slots& slots,
                                   const Points& p, std::uint8_t* out) {
  for (std::size_t i = 0; i < lanes; ++i) {
    const float xyzi[4] = {p.x[i], p.y[i], p.z[i], p.intensity[i]};
    const auto ring = static_cast<std::uint16_t>(lasers.ring[k + i]);
    std::memcpy(out, xyzi, sizeof xyzi);
    std::memcpy(out + 16, &ring, sizeof ring);
    std::memcpy(out + 18, &p.time[i], sizeof p.time[i]);
    const bool is_return =
        slots.count[i] >= lasers.nearest[k + i] && slots.count[i] <= lasers.farthest[k + i];
    out += is_return ? point_step : 0;
  }
  return out;
}

#endif

/// The azimuth of a laser is the sequence's plus the rotation until the firing minus rot_correction.
void turn_lasers(LaserArrays& lasers, double rate) {
  for (std::size_t k = 0; k < lasers.size; ++k) {
    const double turn = rate * lasers.turning[k];
    const double square = turn * turn;
    const double cos_turn = 1 - square * (1.0 / 2 - square * (1.0 / 24 - square * (1.0 / 720)));
    const double sin_turn = turn * (1 - square * (1.0 / 6 - square * (1.0 / 120 - square * (1.0 / 5040))));
    lasers.cos_shift[k] = static_cast<float>(cos_turn * lasers.cos_rot[k] + sin_turn * lasers.sin_rot[k]);
    lasers.sin_shift[k] = static_cast<float>(sin_turn * lasers.cos_rot[k] - cos_turn * lasers.sin_rot[k]);
  }
}

/// Points of `lanes` lasers. The sensor counts azimuth clockwise from ahead; ROS has x ahead and y to the
/// left.
inline void transform_lanes(const LaserArrays& lasers, const SequenceArrays& sequences, std::size_t n,
                            std::size_t first, const Slots& slots, Points& p) {
  const auto cos_a = static_cast<float>(sequences.cosine[n]);
  const auto sin_a = static_cast<float>(sequences.sine[n]);
  for (std::size_t i = 0; i < lanes; ++i) {
    const std::size_t k = first + i;
    const auto count = static_cast<float>(slots.count[i]);
    const float cos_alpha = cos_a * lasers.cos_shift[k] - sin_a * lasers.sin_shift[k];
    const float sin_alpha = sin_a * lasers.cos_shift[k] + cos_a * lasers.sin_shift[k];
    const float ground = count * lasers.ground_step[k] + lasers.ground_begin[k];
    p.x[i] = ground * cos_alpha;
    p.y[i] = -(ground * sin_alpha);
    p.z[i] = count * lasers.up_step[k] + lasers.up_begin[k];
    p.intensity[i] = static_cast<float>(slots.reflectivity[i]);
    p.time[i] = sequences.begin[n] + lasers.time[k];
  }
}

/// The equations of CalibratedGeometry for `lanes` lasers.
inline void transform_lanes_calibrated(const LaserArrays& lasers, const CalibrationArrays& c,
                                       const SequenceArrays& sequences, std::size_t n, std::size_t first,
                                       const Slots& slots, Points& p) {
  const auto cos_a = static_cast<float>(sequences.cosine[n]);
  const auto sin_a = static_cast<float>(sequences.sine[n]);
  for (std::size_t i = 0; i < lanes; ++i) {
    const std::size_t k = first + i;
    const auto count = static_cast<float>(slots.count[i]);
    const float cos_alpha = cos_a * lasers.cos_shift[k] - sin_a * lasers.sin_shift[k];
    const float sin_alpha = sin_a * lasers.cos_shift[k] + cos_a * lasers.sin_shift[k];
    const float d = count * c.step + c.dist_correction[k];
    const float r = d * c.cos_vert[k] - c.r_offset[k];
    const float side_x = c.horiz_offset[k] * cos_alpha;
    const float side_y = c.horiz_offset[k] * sin_alpha;
    const float near = d < c.two_point_below ? 1.0F : 0.0F;
    const float dx = near * c.near_x[k] * (__builtin_fabsf(r * sin_alpha - side_x) - c.far_target);
    const float dy = near * c.near_y[k] * (__builtin_fabsf(r * cos_alpha + side_y) - c.far_target);
    p.x[i] = (r + dy * c.cos_vert[k]) * cos_alpha + side_y;
    p.y[i] = side_x - (r + dx * c.cos_vert[k]) * sin_alpha;
    p.z[i] = (d + dy) * c.sin_vert[k] + c.z_offset[k];
    const float nearness = 1 - count * (1.0F / 65535);
    float value = static_cast<float>(slots.reflectivity[i]) +
                  c.focal_slope[k] * __builtin_fabsf(c.focal[k] - 256 * nearness * nearness);
    value = value < c.min_intensity[k] ? c.min_intensity[k] : value;
    p.intensity[i] = value > c.max_intensity[k] ? c.max_intensity[k] : value;
    p.time[i] = sequences.begin[n] + lasers.time[k];
  }
}

/// Processes `lanes` slots at a time, in order of sequences and banks.
template <typename TransformLanes>
inline void for_all_lanes(const LaserArrays& lasers, SequenceArrays& sequences, std::uint8_t* out,
                          TransformLanes transform_points) {
  const std::size_t per_bank = lasers.size / lasers.banks;
  for (std::size_t n = 0; n < sequences.size; ++n) {
    std::size_t first = 0;
    for (std::size_t bank = 0; bank < lasers.banks; ++bank) {
      const std::uint8_t* slot = sequences.slots[n][bank];
      for (const std::size_t end = first + per_bank; first < end; first += lanes, slot += 3 * lanes) {
        Slots slots;
        Points p;
        read_slots(slot, slots);
        transform_points(n, first, slots, p);
        out = write_returns(lasers, first, slots, p, out);
      }
    }
    sequences.end[n] = out;
  }
}

void transform(const LaserArrays& lasers, SequenceArrays& sequences, std::uint8_t* out) {
  for_all_lanes(lasers, sequences, out, [&](std::size_t n, std::size_t first, const Slots& slots, Points& p) {
    transform_lanes(lasers, sequences, n, first, slots, p);
  });
}

void transform_calibrated(const LaserArrays& lasers, const CalibrationArrays& calibration,
                          SequenceArrays& sequences, std::uint8_t* out) {
  for_all_lanes(lasers, sequences, out, [&](std::size_t n, std::size_t first, const Slots& slots, Points& p) {
    transform_lanes_calibrated(lasers, calibration, sequences, n, first, slots, p);
  });
}

/// Turns the direction of the integer degree by the rest: within half a degree the next terms of the series
/// are below 1e-15.
void find_directions(const WholeDegrees& whole, SequenceArrays& sequences) {
  constexpr double rad_per_deg = 3.14159265358979323846 / 180;
  for (std::size_t i = 0; i < sequences.size; ++i) {
    int index = static_cast<int>(sequences.azimuth_deg[i] + (whole_turn_deg + 0.5));
    index = index < 0 ? 0 : index;
    index = index > 2 * whole_turn_deg ? 2 * whole_turn_deg : index;
    const double rest = (sequences.azimuth_deg[i] - (index - whole_turn_deg)) * rad_per_deg;
    const double square = rest * rest;
    const double cosine = 1 - square * (1.0 / 2 - square * (1.0 / 24));
    const double sine = rest * (1 - square * (1.0 / 6 - square * (1.0 / 120)));
    sequences.cosine[i] = whole[index].cosine * cosine - whole[index].sine * sine;
    sequences.sine[i] = whole[index].sine * cosine + whole[index].cosine * sine;
  }
}

constexpr SequenceKernels kernels = {&turn_lasers, &find_directions, &transform, &transform_calibrated};

}  // namespace
}  // namespace lidard::velodyne
