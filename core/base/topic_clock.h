// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "core/base/device_clock.h"
#include "core/base/time.h"

namespace lidard {

/// Judges the stamps of another node's messages by their arrivals. What was measured after its arrival, or
/// long before it, was stamped by a clock that is not this host's. What replaces the stamp keeps the
/// intervals of that clock and is placed by the arrivals, as the stamps of a device are; a stamp that does
/// not increase becomes the arrival.
class TopicClock {
 public:
  /// `lead`: how far ahead of their arrival stamps may be, as those of predicted poses are.
  explicit TopicClock(Span lead = Span(0)) : lead_(lead) {}
  /// The stamp, or what replaces it. `lasts`: from the stamp to the last measurement of the message;
  /// `arrival`: by the clock that should have made the stamp.
  Stamp correct(Stamp stamp, Span lasts, Stamp arrival);
  /// Stamps that were replaced.
  std::uint64_t replaced() const { return replaced_; }
  /// By how much the clock that stamps the messages is ahead of that of the arrivals; none: at most a few
  /// stamps are of another clock.
  std::optional<Span> ahead() const;

 private:
  Span lead_;
  DeviceClock clock_;
  Stamp newest_{};
  Span ahead_{0};  // of the newest stamp that was replaced
  std::uint64_t replaced_ = 0;
  int strikes_ = 0;
};

}  // namespace lidard
