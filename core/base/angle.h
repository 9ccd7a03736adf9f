// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <optional>

namespace lidard {

constexpr double pi_d = 3.14159265358979323846;
constexpr double two_pi = 2 * pi_d;
constexpr double rad_per_deg = pi_d / 180;
constexpr double deg_per_rad = 180 / pi_d;

/// `angle` brought into [-pi, pi]; at most one turn off.
inline float wrapped(float angle) {
  constexpr auto turn = static_cast<float>(two_pi);
  if (angle > turn / 2) return angle - turn;
  return angle < -turn / 2 ? angle + turn : angle;
}

/// A sector of the circle from `first` counter-clockwise to `last`, rad, first <= last; by default all of it.
/// A limit that is not finite does not limit: then the angles are those of a line, not of a circle.
struct Sector {
  double first = -INFINITY;
  double last = INFINITY;

  double width() const { return last - first; }
  bool is_line() const { return std::isinf(first) || std::isinf(last); }
  bool is_all() const { return width() >= two_pi - 1e-8 && std::isinf(first) == std::isinf(last); }
  /// True if `angle`, in whichever turn, lies inside, or outside by at most `slack`.
  bool holds(double angle, double slack = 1e-9) const {
    if (is_line()) return angle >= first - slack && angle <= last + slack;
    return is_all() || std::fabs(std::remainder(angle - (first + last) / 2, two_pi)) <= width() / 2 + slack;
  }
};

/// The sector between two limits, through straight behind if `first` is the greater.
inline Sector sector_between(std::optional<double> first, std::optional<double> last) {
  Sector sector{first.value_or(-INFINITY), last.value_or(INFINITY)};
  if (sector.last < sector.first)
    sector.last = sector.first + std::fmod(std::fmod(sector.width(), two_pi) + two_pi, two_pi);
  return sector;
}

/// atan2 to about 2e-7 rad, without a branch that depends on the arguments, so that a loop over it can be
/// vectorised; 0 at the origin. Polynomial: Abramowitz and Stegun, Handbook of Mathematical
/// Functions, 4.4.49.
inline float fast_atan2(float y, float x) {
  const float ax = std::fabs(x);
  const float ay = std::fabs(y);
  const float big = ax > ay ? ax : ay;
  const float small = ax > ay ? ay : ax;
  const float z = small / (big + 1e-37F);
  const float s = z * z;
  float p = 0.0028662257F;
  p = p * s - 0.0161657367F;
  p = p * s + 0.0429096138F;
  p = p * s - 0.0752896400F;
  p = p * s + 0.1065626393F;
  p = p * s - 0.1420889944F;
  p = p * s + 0.1999355085F;
  p = p * s - 0.3333314528F;
  p = (p * s + 1.0F) * z;
  p = ay > ax ? static_cast<float>(pi_d / 2) - p : p;
  p = x < 0 ? static_cast<float>(pi_d) - p : p;
  return y < 0 ? -p : p;
}

}  // namespace lidard
