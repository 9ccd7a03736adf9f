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
  auto end = sorted_.begin() + static_cast<std::ptrdiff_t>(std::min(count_, steps_.size()));
  if (count_ >= steps_.size()) {
    sum_ -= steps_[slot];
    const auto oldest = std::lower_bound(sorted_.begin(), end, steps_[slot]);
    end = std::move(oldest + 1, end, oldest);
  }
  steps_[slot] = one;
  sum_ += one;
  ++count_;
  const auto place = std::upper_bound(sorted_.begin(), end, one);
  std::move_backward(place, end, end + 1);
  *place = one;
  const std::int64_t median = sorted_[static_cast<std::size_t>(end + 1 - sorted_.begin()) / 2];
  for (const Timing& timing : row_.timings) {
    if (std::abs(timing.sequence.count() - median) < std::abs(chosen_->sequence.count() - median))
      chosen_ = &timing;
  }
}

Span TimingChooser::measured_sequence() const {
  if (count_ == 0) return chosen_->sequence;
  return Span(sum_ / static_cast<std::int64_t>(std::min(count_, steps_.size())));
}

}  // namespace lidard::velodyne
