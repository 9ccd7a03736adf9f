// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/revolution.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

constexpr double backwards_limit_deg = 1;
/// Slower than this (60 rpm) counts as standing: frames are then cut by time.
constexpr Span slowest_turn = std::chrono::seconds(1);
/// The rate is measured over at least this angle, so that the 0.01 deg steps of the wire do not matter.
constexpr double rate_angle_deg = 90;

/// A sequence right at the cut begins the new revolution, whichever way the last bit was rounded; sums of
/// steps are compared likewise.
constexpr double rounding_deg = 1e-6;

double wrap_deg(double angle) {
  const double a = std::fmod(angle, 360);
  return a < 0 ? a + 360 : a;
}

/// wrap_deg(), without a division for angles within a turn either way.
double wrap_quick_deg(double angle) {
  if (angle >= 0 && angle < 360) return angle;
  return angle < 0 && angle >= -360 ? angle + 360 : wrap_deg(angle);
}

}  // namespace

RevolutionCutter::RevolutionCutter(double cut_deg) : cut_deg_(wrap_deg(cut_deg - rounding_deg)) {}

void RevolutionCutter::reset() {
  started_ = false;
  period_ = Span(0);
}

void RevolutionCutter::measure_rate(double step_deg, Span time) {
  turned_deg_ += step_deg;
  if (turned_deg_ < rate_angle_deg - rounding_deg) return;
  // Overlapping packets can make it negative: then the period is not known.
  const Span elapsed = std::max(time - turned_since_, Span(0));
  period_ = Span(std::llround(static_cast<double>(elapsed.count()) * 360 / turned_deg_));
  turned_deg_ = 0;
  turned_since_ = time;
}

/// Turns without a packet, beyond the step between the azimuths.
int RevolutionCutter::whole_turns(double step_deg, Span elapsed) const {
  if (period_.count() <= 0 || elapsed * 2 < period_) return 0;
  const double turns = static_cast<double>(elapsed.count()) / static_cast<double>(period_.count());
  constexpr double most = 1e6;  // of a period of nanoseconds, which is none
  return std::max(0, static_cast<int>(std::lround(std::min(turns, most) - step_deg / 360)));
}

Span RevolutionCutter::limit() const {
  return period_.count() > 0 && period_ < slowest_turn ? period_ * 3 / 2 : slowest_turn * 3 / 2;
}

bool RevolutionCutter::pass(double first_deg, double last_deg, Span first, Span last) {
  const double turned = last_deg - azimuth_deg_;
  if (!started_ || first_deg < azimuth_deg_ || turned + position_deg_ > 360 - rounding_deg) return false;
  if (turned + turned_deg_ >= rate_angle_deg - rounding_deg || last - frame_start_ > limit()) return false;
  if (period_.count() > 0 && (first - last_time_) * 2 >= period_) return false;
  azimuth_deg_ = last_deg;
  position_deg_ = wrap_quick_deg(last_deg - cut_deg_);
  turned_deg_ += turned;
  last_time_ = last;
  return true;
}

RevolutionCutter::Verdict RevolutionCutter::next(double azimuth_deg, Span time) {
  if (!started_) {
    started_ = true;
    azimuth_deg_ = azimuth_deg;
    position_deg_ = wrap_quick_deg(azimuth_deg - cut_deg_);
    frame_start_ = turned_since_ = last_time_ = time;
    turned_deg_ = 0;
    return Verdict::same;
  }
  const double step = wrap_quick_deg(azimuth_deg - azimuth_deg_);
  const int whole = whole_turns(step, time - last_time_);
  const bool backwards = whole == 0 && step > 360 - backwards_limit_deg;
  last_time_ = time;
  Verdict verdict = Verdict::same;
  if (!backwards) {
    if (position_deg_ + step >= 360) verdict = Verdict::crossed;
    if (whole > 0) verdict = Verdict::forced;
    azimuth_deg_ = azimuth_deg;
    position_deg_ = wrap_quick_deg(azimuth_deg - cut_deg_);
    measure_rate(step + 360.0 * whole, time);
  }
  if (time - frame_start_ > limit()) verdict = Verdict::forced;
  if (verdict != Verdict::same) frame_start_ = time;
  return verdict;
}

}  // namespace lidard
