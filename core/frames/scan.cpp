// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/scan.h"

#include <algorithm>
#include <array>

namespace lidard {

const char* to_string(BeamStatus status) {
  constexpr std::array<const char*, 4> names = {"hit", "none", "near", "invalid"};
  return names.at(static_cast<std::size_t>(status));
}

float range_without_hit(BeamStatus status) {
  if (status == BeamStatus::none) return std::numeric_limits<float>::infinity();
  if (status == BeamStatus::near) return -std::numeric_limits<float>::infinity();
  return std::numeric_limits<float>::quiet_NaN();
}

void PlanarScan::reset(std::size_t beam_count, std::size_t echo_count, bool with_intensities) {
  beams = beam_count;
  echoes = echo_count;
  const std::size_t n = beams * echoes;
  ranges.assign(n, range_without_hit(BeamStatus::invalid));
  statuses.assign(n, BeamStatus::invalid);
  intensities.assign(with_intensities ? n : 0, 0.0F);
  free_from.clear();
  flags.clear();
}

BeamWindow beams_inside(const Sector& sector, double angle, double step, std::size_t beams) {
  if (sector.is_all()) return {0, beams};
  const double slack = 0.01 * std::abs(step);
  BeamWindow window;
  for (std::size_t i = 0; i < beams; ++i) {
    if (!sector.holds(angle + step * static_cast<double>(i), slack)) continue;
    if (window.count == 0) window.first = i;
    const std::size_t at = i - window.first;
    if (at > window.count) window.gap_first = window.count, window.gap_count = at - window.count;
    window.count = at + 1;
  }
  return window;
}

void PlanarScan::hide_gap(const BeamWindow& window) {
  for (std::size_t echo = 0; echo < echoes; ++echo) {
    for (std::size_t beam = window.gap_first; beam < window.gap_first + window.gap_count; ++beam) {
      set_without_hit(index(beam, echo), BeamStatus::invalid);
      if (!intensities.empty()) intensities[index(beam, echo)] = 0;
      if (!flags.empty()) flags[beam] = 0;
    }
  }
}

void PlanarScan::reverse() {
  const auto turn = [this](auto& values) {
    for (auto at = values.begin(); at != values.end(); at += static_cast<std::ptrdiff_t>(beams))
      std::reverse(at, at + static_cast<std::ptrdiff_t>(beams));
  };
  turn(ranges), turn(intensities), turn(statuses), turn(free_from), turn(flags);
  stamp = stamp + span_from_seconds(static_cast<double>(time_increment) * static_cast<double>(beams - 1));
  time_increment = -time_increment;
  set_angles(angle_max, -angle_increment);
}

void PlanarScan::set_angles(float first, float increment) {
  angle_min = first;
  angle_increment = increment;
  angle_max = beams == 0 ? first : even_angle(beams - 1);
}

namespace {

bool beam_is_consistent(const PlanarScan& scan, std::size_t i) {
  const float range = scan.ranges[i];
  if (scan.statuses[i] == BeamStatus::hit) return range >= scan.range_min && range <= scan.range_max;
  const float expected = range_without_hit(scan.statuses[i]);
  return std::isnan(expected) ? std::isnan(range) : range == expected;
}

}  // namespace

void encode_ranges(const PlanarScan& scan, float* ranges) {
  for (std::size_t b = 0; b < scan.beams; ++b) {
    if (scan.statuses[b] == BeamStatus::none) ranges[b] = scan.none_as;
    if (scan.statuses[b] == BeamStatus::invalid) ranges[b] = scan.invalid_as;
  }
}

const char* violation(const PlanarScan& scan) {
  const std::size_t n = scan.beams * scan.echoes;
  if (scan.beams < 1 || scan.echoes < 1) return "no beams";
  if (scan.ranges.size() != n || scan.statuses.size() != n) return "number of ranges is not beams x echoes";
  if (!scan.intensities.empty() && scan.intensities.size() != n)
    return "number of intensities is not that of ranges";
  if (!scan.free_from.empty() && scan.free_from.size() != scan.beams)
    return "number of free_from is not that of beams";
  if (!scan.flags.empty() && scan.flags.size() != scan.beams) return "number of flags is not that of beams";
  if (!std::isfinite(scan.angle_min) || !std::isfinite(scan.angle_increment)) return "angles are not finite";
  if (scan.angle_increment == 0 && scan.beams > 1) return "angle_increment is 0";
  if (scan.angle_max != scan.even_angle(scan.beams - 1)) return "angle_max is not that of the last beam";
  if (!(scan.range_min >= 0 && scan.range_max > scan.range_min)) return "range limits are not 0 <= min < max";
  for (std::size_t i = 0; i < n; ++i) {
    if (!beam_is_consistent(scan, i)) return "a range does not fit its status";
  }
  return nullptr;
}

}  // namespace lidard
