// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/scan_grid.h"

#include <cmath>

namespace lidard {
namespace {

constexpr double pi = 3.14159265358979323846;
constexpr std::size_t max_beams = 32768;
constexpr std::size_t default_full_circle_beams = 1440;

bool all_finite(const ScanGridSpec& s) {
  return std::isfinite(s.angle_min) && std::isfinite(s.angle_max) && std::isfinite(s.range_min) &&
         std::isfinite(s.range_max) && std::isfinite(s.time_increment) && std::isfinite(s.scan_time) &&
         std::isfinite(s.angle_increment.value_or(1));
}

std::string complaint(const ScanGridSpec& s) {
  if (!all_finite(s)) return "a number is not finite; expected finite angles, ranges and times";
  if (s.angle_min < -2 * pi || s.angle_max > 2 * pi + 1e-6)
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
  if (s.beams) return 2 * pi / static_cast<double>(*s.beams) * (span / (2 * pi));
  return 2 * pi / static_cast<double>(default_full_circle_beams);
}

}  // namespace

std::optional<ScanGrid> make_grid(const ScanGridSpec& spec, std::string& error) {
  error = complaint(spec);
  if (!error.empty()) return std::nullopt;
  const double span = spec.angle_max - spec.angle_min;
  const double wanted = wanted_increment(spec, span);
  if (span > 2 * pi + wanted / 2) {
    error = "angle_min to angle_max is more than a full turn; expected a span of at most 2 pi";
    return std::nullopt;
  }
  ScanGrid grid;
  grid.angle_min = spec.angle_min;
  grid.full_circle = std::abs(span - 2 * pi) < wanted / 2;
  const double steps = std::round((grid.full_circle ? 2 * pi : span) / wanted);
  if (!(steps < static_cast<double>(max_beams)) || steps < 1) {
    error =
        "the span has " + std::to_string(steps) + " increments; expected 1 to 32767: change angle_increment";
    return std::nullopt;
  }
  grid.beams = static_cast<std::size_t>(steps);
  if (grid.full_circle) {
    grid.increment = 2 * pi / steps;
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
  double turn = std::fmod(angle - angle_min, 2 * pi);
  if (turn < 0) turn += 2 * pi;
  const auto index = static_cast<std::size_t>(turn / increment + 0.5);
  if (index < beams) return index;
  if (full_circle) return 0;
  return turn - 2 * pi > -increment / 2 ? 0 : beams;
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
