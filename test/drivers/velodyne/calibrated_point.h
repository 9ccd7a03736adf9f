// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "drivers/velodyne/calibration.h"

namespace lidard::velodyne {

/// A return in the sensor's ROS frame (REP 103), m.
struct CalibratedPoint {
  float x, y, z;
  float intensity;
};

/// The equations of CalibratedGeometry in double, one return at a time: what the loops of sequence_kernel.h,
/// which do the same in float for eight at once, are tested against. The azimuth is that of the firing,
/// clockwise from ahead, still without rot_correction.
inline CalibratedPoint place(const CalibratedGeometry& geometry, std::size_t laser, std::uint16_t count,
                             std::uint8_t raw_intensity, double cos_azimuth, double sin_azimuth) {
  constexpr double far_target_m = CalibratedGeometry::far_target_m;
  const CalibratedGeometry::Terms& t = geometry.terms(laser);
  const double cos_alpha = cos_azimuth * t.cos_rot + sin_azimuth * t.sin_rot;
  const double sin_alpha = sin_azimuth * t.cos_rot - cos_azimuth * t.sin_rot;
  const double d = geometry.distance(laser, count);
  const double r = d * t.cos_vert - t.r_offset;
  const double side_x = t.horiz_offset * cos_alpha;
  const double side_y = t.horiz_offset * sin_alpha;
  double dx = 0;
  double dy = 0;
  if (t.two_point && d < geometry.two_point_below_m()) {
    dx = t.near_x * (std::abs(r * sin_alpha - side_x) - far_target_m);
    dy = t.near_y * (std::abs(r * cos_alpha + side_y) - far_target_m);
  }
  const double right = (r + dx * t.cos_vert) * sin_alpha - side_x;
  const double ahead = (r + dy * t.cos_vert) * cos_alpha + side_y;
  const double up = (d + dy) * t.sin_vert + t.z_offset;
  const double nearness = 1 - count * (1.0 / 65535);
  double intensity = raw_intensity + t.focal_slope * std::abs(t.focal - 256 * nearness * nearness);
  intensity = intensity < t.min_intensity ? t.min_intensity : intensity;
  intensity = intensity > t.max_intensity ? t.max_intensity : intensity;
  return {static_cast<float>(ahead), static_cast<float>(-right), static_cast<float>(up),
          static_cast<float>(intensity)};
}

}  // namespace lidard::velodyne
