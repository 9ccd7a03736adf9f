// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/scan_grid.h"

#include <cmath>

namespace lidard {
namespace {

constexpr std::size_t max_beams = 32768;
constexpr std::size_t default_full_circle_beams = 1440;

bool all_finite(const ScanGridSpec& s) {
  return std::isfinite(s.angle_min) && std::isfinite(s.angle_max) && std::isfinite(s.range_min) &&
         std::isfinite(s.range_max) && std::isfinite(s.time_increment) && std::isfinite(s.scan_time) &&
         std::isfinite(s.angle_increment.value_or(1));
}

std::string complaint(const ScanGridSpec& s) {
  if (!all_finite(s)) return "a number is not finite; expected finite angles, ranges and times";
  if (s.angle_min < -two_pi || s.angle_max > two_pi + 1e-6)
    return "angle_min or angle_max is beyond a full turn; expected radians within -2 pi and 2 pi";
  if (s.angle_max <= s.angle_min) return "angle_max is not above angle_min; expected angle_min < angle_max";
  if (s.angle_increment && s.beams) return "both angle_increment and beams are given; expected one of them";
  if (s.angle_increment && *s.angle_increment <= 0)
    return "angle_increment is not positive; expected a value above 0";
  if (s.beams && *s.beams < 2) return "beams is below 2; expected 2 or more";
  if (s.range_min < 0) return "range_min is negative; expected 0 or more";
  if (s.range_max <= s.range_min) return "range_max is not above range_min; expected range_min < range_max";
  if (s.time_increment < 0 || s.scan_time < 0)
    return "time_increment or scan_time is negative; expected 0 or more";
  return {};
}

double wanted_increment(const ScanGridSpec& s, double span) {
  if (s.angle_increment) return *s.angle_increment;
  if (s.beams) return two_pi / static_cast<double>(*s.beams) * (span / two_pi);
  return two_pi / static_cast<double>(default_full_circle_beams);
}

}  // namespace

Expected<ScanGrid> make_grid(const ScanGridSpec& spec) {
  std::string wrong = complaint(spec);
  if (!wrong.empty()) return Reason{std::move(wrong)};
  const double span = spec.angle_max - spec.angle_min;
  const double wanted = wanted_increment(spec, span);
  if (span > two_pi + wanted / 2)
    return Reason{"angle_min to angle_max is more than a full turn; expected a span of at most 2 pi"};
  ScanGrid grid;
  grid.angle_min = spec.angle_min;
  grid.full_circle = std::abs(span - two_pi) < wanted / 2;
  const double steps = std::round((grid.full_circle ? two_pi : span) / wanted);
  if (!(steps < static_cast<double>(max_beams)) || steps < 1)
    return Reason{"the span has " + std::to_string(steps) +
                  " increments; expected 1 to 32767: change angle_increment"};
  grid.beams = static_cast<std::size_t>(steps);
  if (grid.full_circle) {
    grid.increment = two_pi / steps;
  } else if (spec.beams) {
    grid.beams = *spec.beams;
    grid.increment = span / static_cast<double>(grid.beams - 1);
  } else {
    grid.beams += 1;
    grid.increment = wanted;
  }
  grid.time_increment = spec.time_increment;
  grid.scan_time = spec.scan_time;
  grid.range_min = spec.range_min;
  grid.range_max = spec.range_max;
  return grid;
}

std::size_t ScanGrid::nearest(double angle) const {
  double turn = std::fmod(angle - angle_min, two_pi);
  if (turn < 0) turn += two_pi;
  const auto index = static_cast<std::size_t>(std::floor(turn / increment + 0.5));
  if (index < beams) return index;
  if (full_circle) return 0;
  return turn - two_pi > -increment / 2 ? 0 : beams;
}

void ScanGrid::prepare(PlanarScan& scan, bool with_intensities) const {
  scan.reset(beams, 1, with_intensities);
  scan.set_angles(static_cast<float>(angle_min), static_cast<float>(increment));
  scan.time_increment = static_cast<float>(time_increment);
  scan.scan_time = static_cast<float>(scan_time);
  scan.range_min = static_cast<float>(range_min);
  scan.range_max = static_cast<float>(range_max);
}

}  // namespace lidard
