// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_geometry.h"

#include <cmath>

#include "core/base/angle.h"
#include "core/base/number_text.h"

namespace lidard::sick {
namespace {

/// The turn of the mirror by the measurement frequency, s; 0 unknown.
double turn_by_measurements(const ColaScan& scan, double step_deg) {
  return scan.measurement_hz > 0 && step_deg > 0 ? 360 / step_deg / scan.measurement_hz : 0;
}

/// Time between neighbouring beams. The scan frequency is the exact one of both frequencies; how many scans
/// a turn gives is the row's, unless the measurement frequency says otherwise.
double beam_period(const ColaScan& scan, const ColaRow& row, double step_deg) {
  if (!(scan.scan_hz > 0)) return 0;
  constexpr double tolerance = 0.02;
  const double period = 1 / scan.scan_hz;
  const double told = turn_by_measurements(scan, step_deg);
  double turn = row.turn * period;
  for (int scans = 1; scans <= 4; ++scans) {
    if (told > 0 && std::abs(told - scans * period) <= tolerance * told) turn = scans * period;
  }
  return turn * step_deg / 360;
}

}  // namespace

double exact_step_deg(double told) {
  constexpr double half_unit = 0.5e-4;
  for (int parts = 1; parts <= 3 && told > 0; ++parts) {
    const double exact = parts / std::round(parts / told);
    if (std::abs(exact - told) <= half_unit) return exact;
  }
  return told;
}

double ColaGeometry::angle(const ColaRow& row, double beam) const {
  const double deg = start_deg + step_deg * beam + row.shift_deg;
  return (row.mirrored ? -deg : deg) * rad_per_deg;
}

Span ColaGeometry::sweep() const {
  return span_from_seconds(beam_period * static_cast<double>(beams == 0 ? 0 : beams - 1));
}

bool operator==(const ColaGeometry& a, const ColaGeometry& b) {
  return a.beams == b.beams && a.echoes == b.echoes && a.start_deg == b.start_deg &&
         a.step_deg == b.step_deg && a.scan_hz == b.scan_hz && a.beam_period == b.beam_period;
}

bool read_geometry(const ColaScan& scan, const ColaRow& row, ColaGeometry& geometry) {
  const ColaChannel* first = scan.channel("DIST1");
  if (first == nullptr || first->values.empty() || !(first->step_deg > 0)) return false;
  geometry.beams = first->values.size();
  geometry.echoes = scan.echo_count();
  geometry.start_deg = first->start_deg;
  geometry.step_deg = exact_step_deg(first->step_deg);
  geometry.scan_hz = scan.scan_hz;
  geometry.beam_period = beam_period(scan, row, geometry.step_deg);
  constexpr double full_turn = 360.5;
  if (geometry.step_deg * static_cast<double>(geometry.beams - 1) > full_turn) return false;
  for (std::size_t i = 1; i < geometry.echoes; ++i) {
    const ColaChannel* other = scan.channel(distance_names[i]);
    if (other->values.size() != geometry.beams || other->start_deg != first->start_deg ||
        other->step_deg != first->step_deg)
      return false;
  }
  return true;
}

std::string describe(const ColaGeometry& g) {
  return printed("%zu beams from %.4f deg in steps of %.5f deg, %.2f Hz", g.beams, g.start_deg, g.step_deg,
                 g.scan_hz);
}

BeamStatus status_of_raw(std::uint16_t raw) {
  if (raw >= first_distance) return BeamStatus::hit;
  return raw == 0 ? BeamStatus::none : BeamStatus::invalid;
}

}  // namespace lidard::sick
