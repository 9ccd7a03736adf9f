// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "core/base/time.h"

namespace lidard {

/// How long something may take: the answer to a question, a pause.
class Patience {
 public:
  void start(Stamp now, Span limit) { since_ = now, limit_ = limit; }
  /// A clock that was set back begins the time anew.
  bool is_over(Stamp now) {
    since_ = std::min(since_, now);
    return now - since_ > limit_;
  }
  Stamp since() const { return since_; }

 private:
  Stamp since_{};
  Span limit_{0};
};

}  // namespace lidard
