// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/timing_chooser.h"

#include <algorithm>
#include <cstdlib>

namespace lidard::velodyne {

void TimingChooser::add(Span step, std::size_t sequences) {
  if (row_.timings.size() == 1 && !row_.random_rest) return;
  const std::int64_t one = step.count() / static_cast<std::int64_t>(sequences);
  // A lost packet doubles the step: not a period.
  if (one * 2 > row_.timings.front().sequence.count() * 3 || one * 2 < row_.timings.front().sequence.count())
    return;
  const std::size_t slot = count_ % steps_.size();
  if (count_ >= steps_.size()) sum_ -= steps_[slot];
  steps_[slot] = one;
  sum_ += one;
  ++count_;
  auto sorted = steps_;
  const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(std::min(count_, steps_.size()));
  const auto middle = sorted.begin() + (end - sorted.begin()) / 2;
  std::nth_element(sorted.begin(), middle, end);
  for (const Timing& timing : row_.timings) {
    if (std::abs(timing.sequence.count() - *middle) < std::abs(chosen_->sequence.count() - *middle))
      chosen_ = &timing;
  }
}

Span TimingChooser::measured_sequence() const {
  if (count_ == 0) return chosen_->sequence;
  return Span(sum_ / static_cast<std::int64_t>(std::min(count_, steps_.size())));
}

}  // namespace lidard::velodyne
