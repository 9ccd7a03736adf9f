// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

#include "core/base/time.h"

namespace lidard {

/// How long the last frames of a topic took. No allocation.
class LatencyWindow {
 public:
  struct Figures {
    std::size_t frames = 0;  ///< that the others are of
    Span median{0}, p99{0}, longest{0};
  };

  void add(Span latency) {
    window_[next_] = latency;
    next_ = (next_ + 1) % window_.size();
    count_ = std::min(count_ + 1, window_.size());
  }
  Figures figures() const {
    if (count_ == 0) return {};
    std::array<Span, length> sorted = window_;
    std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count_));
    return {count_, sorted[count_ / 2], sorted[count_ * 99 / 100], sorted[count_ - 1]};
  }

 private:
  static constexpr std::size_t length = 512;
  std::array<Span, length> window_{};
  std::size_t next_ = 0, count_ = 0;
};

}  // namespace lidard
