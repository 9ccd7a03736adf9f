// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/velodyne_head.h"

#include <cmath>

namespace lidard::sim {

VelodyneHead::VelodyneHead(const VelodyneTiming& timing, const VelodyneOptions& options, std::size_t group,
                           double step_deg, Stamp start)
    : timing_(timing),
      turn_deg_(options.turn_deg.value_or(timing.turn_deg)),
      start_deg_(options.start_azimuth_deg),
      fov_(options.fov),
      rest_spread_ns_(options.rest_spread_ns),
      group_(group),
      step_deg_(step_deg),
      start_(start),
      next_(start),
      rng_(1) {}

double VelodyneHead::azimuth_deg(Stamp time) const {
  const auto since = static_cast<double>((time - start_).count());
  const double turned = since / static_cast<double>(timing_.period_ns()) * turn_deg_;
  return std::fmod(start_deg_ + turned, 360.0);
}

std::uint16_t VelodyneHead::wire_azimuth(Stamp time) const {
  double azimuth = azimuth_deg(time);
  constexpr double rounding = 1e-9;
  if (step_deg_ > 0) azimuth = std::floor(azimuth / step_deg_ + rounding) * step_deg_;
  return static_cast<std::uint16_t>(std::llround(azimuth * 100) % 36000);
}

Stamp VelodyneHead::next_group() {
  Stamp begin;
  do {
    begin = next_;
    for (std::size_t i = 0; i < group_; ++i) next_ = next_ + Span(timing_.sequence_ns + rest());
  } while (!visible(begin));
  return begin;
}

bool VelodyneHead::visible(Stamp time) const {
  if (!fov_) return true;
  const int azimuth = wire_azimuth(time);
  const auto start = std::lround(fov_->start_deg * 100);
  const auto end = std::lround(fov_->end_deg * 100);
  return start <= end ? azimuth >= start && azimuth <= end : azimuth >= start || azimuth <= end;
}

std::int64_t VelodyneHead::rest() {
  if (timing_.rest_ns == 0) return 0;
  return timing_.rest_ns + std::llround(static_cast<double>(rest_spread_ns_) * (2 * rng_.uniform() - 1));
}

}  // namespace lidard::sim
