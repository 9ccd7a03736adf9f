// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/calibration.h"

namespace lidard {

bool operator==(const LaserCalibration& a, const LaserCalibration& b);

namespace velodyne {

struct ModelRow;

/// Rings in ascending order of elevation, equal ones in order of the laser's number.
std::vector<std::uint16_t> rings_by_elevation(const Calibration& calibration);

/// Transforms returns with a calibration; terms that do not depend on the return are precomputed.
///
/// With D the distance with its far correction, ω the elevation, α the azimuth without rot_correction, v and
/// h the offsets (sensor frame: Y ahead, X right):
///
///     exact, veloview: r = D cos ω        Z = Dy sin ω + v
///     ros_drivers:  r = D cos ω − v sin ω  Z = Dy sin ω + v cos ω
///     X = r(Dx) sin α − h cos α           Y = r(Dy) cos α + h sin α
///
/// where Dx and Dy are D with a correction interpolated between near and far in proportion to |X| and |Y|.
/// The loops of sequence_kernel.h compute this in float, for eight returns at once.
class CalibratedGeometry {
 public:
  explicit CalibratedGeometry(const Calibration& calibration);

  std::size_t lasers() const { return lasers_.size(); }
  /// The distance with its far correction, m; range limits apply to it.
  double distance(std::size_t laser, std::uint16_t count) const {
    return count * step_m_ + lasers_[laser].dist_correction;
  }

  /// Distances of the two-point calibration: 63-HDL64ES3 Rev K p. 43.
  static constexpr double far_target_m = 25.04;
  static constexpr double near_target_x_m = 2.40;
  static constexpr double near_target_y_m = 1.93;

  /// The terms of one laser.
  struct Terms {
    double rot_correction, cos_rot, sin_rot, cos_vert, sin_vert;
    double dist_correction, horiz_offset;
    double r_offset, z_offset;  ///< vert_offset, subtracted from the ground distance and added to the height
    double near_x, near_y;      ///< change of the correction per metre towards the near target
    double focal, focal_slope;
    double min_intensity, max_intensity;
    bool two_point;
    /// True if distance and angles alone give a point and intensities are raw.
    bool is_straight() const {
      return horiz_offset == 0 && !two_point && focal_slope == 0 && min_intensity <= 0 &&
             max_intensity >= 255;
    }
  };
  const Terms& terms(std::size_t laser) const { return lasers_[laser]; }
  double step_m() const { return step_m_; }
  /// The near corrections apply to shorter distances.
  double two_point_below_m() const { return two_point_below_m_; }

 private:
  static Terms terms_of(const LaserCalibration& laser, CalibrationModel model);

  double step_m_;
  double two_point_below_m_;
  std::vector<Terms> lasers_;
};

/// The model's table as a calibration: angles and heights.
Calibration table_of(const ModelRow& row);

}  // namespace velodyne
}  // namespace lidard
