// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <string>

#include "core/base/number_text.h"
#include "core/base/time.h"
#include "core/frames/scan.h"
#include "drivers/sick/safety/ms3_telegram.h"

namespace lidard::sick {

/// True if beams, angles and times are the same; the distance factor may differ.
inline bool same_geometry(const Ms3Derived& a, const Ms3Derived& b) {
  return a.beams == b.beams && a.raw_start == b.raw_start && a.raw_step == b.raw_step &&
         a.scan_time_ms == b.scan_time_ms && a.beam_period_us == b.beam_period_us;
}

/// "48 beams from -10.5597 deg in steps of 0.51306 deg, 30 ms a scan".
inline std::string describe(const Ms3Derived& d) {
  return printed("%u beams from %.4f deg in steps of %.5f deg, %u ms a scan", d.beams, d.start_deg,
                 d.step_deg, d.scan_time_ms);
}

/// Time between neighbouring beams. The announced one is rounded to us, 0.3 ms in a scan; the exact one
/// follows from the turn of the mirror and is taken where it agrees.
inline Span beam_period(const Ms3Derived& d) {
  const Span announced = std::chrono::microseconds(d.beam_period_us);
  const Span exact = span_from_seconds(d.scan_time_ms * 1e-3 * std::abs(d.step_deg) / 360);
  return std::chrono::abs(exact - announced) <= std::chrono::microseconds(1) ? exact : announced;
}

/// What the flags of a beam say of it. A dazzled receiver misses what is there, so glare comes before "no
/// echo": never free space by mistake.
inline BeamStatus status_of(Ms3Beam beam) {
  if (beam.is(ms3_beam::glare)) return BeamStatus::invalid;
  if (beam.is(ms3_beam::infinite)) return BeamStatus::none;
  return beam.is(ms3_beam::valid) ? BeamStatus::hit : BeamStatus::invalid;
}

}  // namespace lidard::sick
