// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/time.h"

namespace lidard {

/// Decides where one revolution of a rotating lidar ends and the next begins, firing sequence by firing
/// sequence.
///
/// The cut may lie at any azimuth, also inside a sector the sensor does not send: the step across the hidden
/// sector then spans it. Small steps backwards (motor jitter) never cut.
class RevolutionCutter {
 public:
  /// `cut_deg`: azimuth of the cut as the sensor counts it, degrees.
  explicit RevolutionCutter(double cut_deg);

  /// Where a sequence belongs.
  enum class Verdict {
    same,     ///< to the current frame
    crossed,  ///< first of a new frame; the old one reached the cut
    forced  ///< first of a new frame; the old one was given up: a whole turn is missing, more than 1.5 turns
            ///< of time without a cut, or the motor stands still
  };
  /// Next firing sequence, in order of time. `azimuth_deg` in [0, 360), `time` the unwrapped device time.
  Verdict next(double azimuth_deg, Span time);
  /// Accepts several sequences at once, whose azimuths grow from `first_deg` to `last_deg` without a wrap and
  /// whose times from `first` to `last` are a small part of a turn. False, without effect, unless next()
  /// would answer `same` to each of them and measure nothing.
  bool pass(double first_deg, double last_deg, Span first, Span last);

  /// Time of one revolution as last measured; 0 while unknown.
  Span period() const { return period_; }
  void reset();

 private:
  void measure_rate(double step_deg, Span time);
  int whole_turns(double step_deg, Span elapsed) const;
  /// Longest time of a frame.
  Span limit() const;

  double cut_deg_;
  bool started_ = false;
  double position_deg_ = 0;  // since the cut, [0, 360)
  double azimuth_deg_ = 0;
  Span frame_start_{0};
  Span last_time_{0};
  double turned_deg_ = 0;
  Span turned_since_{0};
  Span period_{0};
};

}  // namespace lidard
