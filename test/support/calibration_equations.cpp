// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/calibration_equations.h"

#include <cmath>

namespace lidard::test {
namespace {

double limited(double intensity, const LaserCalibration& laser) {
  intensity = std::fmax(intensity, laser.min_intensity);
  return std::fmin(intensity, laser.max_intensity);
}

}  // namespace

PlacedPoint place_like_ros_drivers(const LaserCalibration& laser, bool two_point, double step_m, int count,
                                   int raw_intensity, double azimuth) {
  const double far = laser.dist_correction;
  const double distance = count * step_m + far;
  const double alpha = azimuth - laser.rot_correction;
  const double omega = laser.vert_correction;
  const double v = laser.vert_offset;
  const double h = laser.horiz_offset;
  const double xy = distance * std::cos(omega) - v * std::sin(omega);
  const double xx = std::fabs(xy * std::sin(alpha) - h * std::cos(alpha));
  const double yy = std::fabs(xy * std::cos(alpha) + h * std::sin(alpha));
  double correction_x = 0;
  double correction_y = 0;
  if (two_point) {
    correction_x = (far - laser.dist_correction_x) * (xx - 2.40) / (25.04 - 2.40) + laser.dist_correction_x;
    correction_x -= far;
    correction_y = (far - laser.dist_correction_y) * (yy - 1.93) / (25.04 - 1.93) + laser.dist_correction_y;
    correction_y -= far;
  }
  const double xy_x = (distance + correction_x) * std::cos(omega) - v * std::sin(omega);
  const double x = xy_x * std::sin(alpha) - h * std::cos(alpha);
  const double xy_y = (distance + correction_y) * std::cos(omega) - v * std::sin(omega);
  const double y = xy_y * std::cos(alpha) + h * std::sin(alpha);
  const double z = (distance + correction_y) * std::sin(omega) + v * std::cos(omega);
  const double offset = 256 * std::pow(1 - laser.focal_distance / 13100, 2);
  const double change = laser.focal_slope * std::fabs(offset - 256 * std::pow(1 - count / 65535., 2));
  return {y, -x, z, limited(raw_intensity + change, laser)};
}

PlacedPoint place_like_manual(const LaserCalibration& laser, bool two_point, double step_m, int count,
                              int raw_intensity, double azimuth) {
  const double far_cm = laser.dist_correction * 100;
  const double raw_cm = count * step_m * 100;
  const double distance_cm = raw_cm + far_cm;
  const double alpha = azimuth - laser.rot_correction;
  const double omega = laser.vert_correction;
  const double h_cm = laser.horiz_offset * 100;
  const double xy = distance_cm * std::cos(omega);
  double correction_x = far_cm;
  double correction_y = far_cm;
  if (two_point && distance_cm < 2504) {
    const double xx = std::fabs(xy * std::sin(alpha) - h_cm * std::cos(alpha));
    const double yy = std::fabs(xy * std::cos(alpha) + h_cm * std::sin(alpha));
    const double near_x = laser.dist_correction_x * 100;
    const double near_y = laser.dist_correction_y * 100;
    correction_x = near_x + (far_cm - near_x) * (xx - 240) / (2504 - 240);
    correction_y = near_y + (far_cm - near_y) * (yy - 193) / (2504 - 193);
  }
  const double x = (raw_cm + correction_x) * std::cos(omega) * std::sin(alpha) - h_cm * std::cos(alpha);
  const double y = (raw_cm + correction_y) * std::cos(omega) * std::cos(alpha) + h_cm * std::sin(alpha);
  const double z = (raw_cm + correction_y) * std::sin(omega) + laser.vert_offset * 100;
  const double offset = 256 * std::pow(1 - laser.focal_distance * 100 / 13100, 2);
  const double change = laser.focal_slope * std::fabs(offset - 256 * std::pow(1 - count / 65535., 2));
  return {y / 100, -x / 100, z / 100, limited(raw_intensity + change, laser)};
}

}  // namespace lidard::test
