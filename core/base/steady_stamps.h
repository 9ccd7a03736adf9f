// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/time.h"

namespace lidard {

/// Stamps of one stream of frames: strictly increasing, since consumers drop what is not newer. Only a clock
/// that was set by more than a second may go back.
class SteadyStamps {
 public:
  Stamp next(Stamp stamp) {
    constexpr Span hidden_step = std::chrono::seconds(1);
    const bool back_a_little = stamp <= last_ && last_ - stamp < hidden_step;
    last_ = back_a_little ? last_ + Span(1) : stamp;
    return last_;
  }
  void reset() { last_ = Stamp(); }

 private:
  Stamp last_;
};

}  // namespace lidard
