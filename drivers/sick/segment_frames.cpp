// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/segment_frames.h"

#include <utility>

namespace lidard::sick {

void WarningSlots::set(Slot slot, std::string text) {
  if (texts_[slot] == text) return;
  texts_[slot] = std::move(text);
  info_.warnings.clear();
  for (const std::string& each : texts_) {
    if (!each.empty()) info_.warnings.push_back(each);
  }
}

Stamp SteadyStamps::next(Stamp stamp) {
  // Consumers drop what is not newer. Only a clock that was set by more than that may go back.
  constexpr Span hidden_step = std::chrono::seconds(1);
  const bool back_a_little = stamp <= last_ && last_ - stamp < hidden_step;
  last_ = back_a_little ? last_ + Span(1) : stamp;
  return last_;
}

}  // namespace lidard::sick
