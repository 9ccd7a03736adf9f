// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/ms3_geometry.h"

#include <array>
#include <cmath>
#include <cstdio>

namespace lidard::sick {

bool same_geometry(const Ms3Derived& a, const Ms3Derived& b) {
  return a.beams == b.beams && a.raw_start == b.raw_start && a.raw_step == b.raw_step &&
         a.scan_time_ms == b.scan_time_ms && a.beam_period_us == b.beam_period_us;
}

std::string describe(const Ms3Derived& d) {
  std::array<char, 128> text{};
  std::snprintf(text.data(), text.size(), "%u beams from %.4f deg in steps of %.5f deg, %u ms a scan",
                d.beams, d.start_deg, d.step_deg, d.scan_time_ms);
  return text.data();
}

// The announced one is rounded to us, 0.3 ms in a scan; the exact one
// follows from the turn of the mirror and is taken where it agrees.
Span beam_period(const Ms3Derived& d) {
  const Span announced = std::chrono::microseconds(d.beam_period_us);
  const Span exact = span_from_seconds(d.scan_time_ms * 1e-3 * std::abs(d.step_deg) / 360);
  return std::chrono::abs(exact - announced) <= std::chrono::microseconds(1) ? exact : announced;
}

// A dazzled receiver misses what is there, so glare comes before "no echo": never free space by mistake.
BeamStatus status_of(Ms3Beam beam) {
  if (beam.is(ms3_beam::glare)) return BeamStatus::invalid;
  if (beam.is(ms3_beam::infinite)) return BeamStatus::none;
  return beam.is(ms3_beam::valid) ? BeamStatus::hit : BeamStatus::invalid;
}

}  // namespace lidard::sick
