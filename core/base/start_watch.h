// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/time.h"

namespace lidard {

/// Detects the first second after a start, in which silence is no fault. A jump of the clock, a pause of the
/// program and a hole in a capture count as starts.
class StartWatch {
 public:
  /// Time passes. True if this is a beginning.
  bool step(Stamp at) {
    const Span passed = at - newest_;
    newest_ = at;
    if (started_ && passed >= -patience && passed <= patience) return false;
    started_ = true;
    since_ = at;
    return true;
  }
  /// `begun`: when what is judged was added.
  bool is_starting(Stamp at, Stamp begun) const {
    return !started_ || at - since_ < patience || (at >= begun && at - begun < patience);
  }

 private:
  static constexpr Span patience = std::chrono::seconds(1);
  bool started_ = false;
  Stamp since_{};
  Stamp newest_{};
};

}  // namespace lidard
