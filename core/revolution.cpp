// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/revolution.h"

#include <cmath>

namespace lidard {
namespace {

constexpr double backwards_limit_deg = 1;
/// Slower than this (60 rpm) counts as standing: frames are then cut by time.
constexpr Span slowest_turn = std::chrono::seconds(1);
/// The rate is measured over at least this angle, so that the 0.01 deg steps of the wire do not matter.
constexpr double rate_angle_deg = 90;

double wrap_deg(double angle) {
  const double a = std::fmod(angle, 360);
  return a < 0 ? a + 360 : a;
}

}  // namespace

RevolutionCutter::RevolutionCutter(double cut_deg) : cut_deg_(wrap_deg(cut_deg)) {}

void RevolutionCutter::reset() {
  started_ = false;
  period_ = Span(0);
}

void RevolutionCutter::measure_rate(double step_deg, Span time) {
  turned_deg_ += step_deg;
  if (turned_deg_ < rate_angle_deg) return;
  const Span elapsed = time - turned_since_;
  period_ = Span(std::llround(static_cast<double>(elapsed.count()) * 360 / turned_deg_));
  turned_deg_ = 0;
  turned_since_ = time;
}

RevolutionCutter::Verdict RevolutionCutter::next(double azimuth_deg, Span time) {
  if (!started_) {
    started_ = true;
    azimuth_deg_ = azimuth_deg;
    position_deg_ = wrap_deg(azimuth_deg - cut_deg_);
    frame_start_ = turned_since_ = last_time_ = time;
    turned_deg_ = 0;
    return Verdict::same;
  }
  const double step = wrap_deg(azimuth_deg - azimuth_deg_);
  const bool backwards = step > 360 - backwards_limit_deg;
  last_time_ = time;
  Verdict verdict = Verdict::same;
  if (!backwards) {
    if (position_deg_ + step >= 360) verdict = Verdict::crossed;
    azimuth_deg_ = azimuth_deg;
    position_deg_ = wrap_deg(azimuth_deg - cut_deg_);
    measure_rate(step, time);
  }
  const Span limit = period_.count() > 0 && period_ < slowest_turn ? period_ * 3 / 2 : slowest_turn * 3 / 2;
  if (time - frame_start_ > limit) verdict = Verdict::forced;
  if (verdict != Verdict::same) frame_start_ = time;
  return verdict;
}

}  // namespace lidard
