// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/base/time.h"

namespace lidard {

/// Knows whether all has only just begun: within a second of the start silence says nothing yet. A clock that
/// jumps, a program that was stopped and a hole in a capture are beginnings too.
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
  bool is_starting(Stamp at) const { return !started_ || at - since_ < patience; }

 private:
  static constexpr Span patience = std::chrono::seconds(1);
  bool started_ = false;
  Stamp since_{};
  Stamp newest_{};
};

}  // namespace lidard
