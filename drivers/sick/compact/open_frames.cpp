// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/compact/open_frames.h"

namespace lidard::sick {

bool OpenFrames::find_slot(std::uint64_t number, std::size_t& slot) const {
  for (std::size_t i = 0; i < most; ++i) {
    if (frames_[i].open && frames_[i].number == number) {
      slot = i;
      return true;
    }
  }
  return false;
}

std::size_t OpenFrames::open_count() const {
  return (frames_[0].open ? 1U : 0U) + (frames_[1].open ? 1U : 0U);
}

std::size_t OpenFrames::oldest() const {
  if (open_count() < 2) return frames_[0].open ? 0 : 1;
  return frames_[0].number < frames_[1].number ? 0 : 1;
}

std::size_t OpenFrames::newest() const { return open_count() < 2 ? oldest() : 1 - oldest(); }

bool OpenFrames::is_complete(const Frame& frame) const {
  return expected_ != 0 && (frame.segments & expected_) == expected_;
}

/// True if nothing more of the old frame can come: the new one continues it without a gap, or has gone on.
bool OpenFrames::is_overtaken(const Frame& old_frame, const Frame& new_frame) const {
  if (new_frame.telegrams > 1) return true;
  return old_frame.is_gapless() && new_frame.first_counter == old_frame.last_counter + 1 && released_any_ &&
         old_frame.first_counter == released_counter_ + 1;
}

std::size_t OpenFrames::missing(std::size_t slot) const {
  std::size_t count = 0;
  for (std::uint64_t rest = expected_ & ~frames_[slot].segments; rest != 0; rest &= rest - 1) ++count;
  return count;
}

void OpenFrames::close(std::size_t slot) {
  Frame& frame = frames_[slot];
  frame.open = false;
  const bool head_is_there = released_any_ && frame.first_counter == released_counter_ + 1;
  const Frame& other = frames_[1 - slot];
  const bool tail_is_there = other.open && other.first_counter == frame.last_counter + 1;
  frame.proven = frame.is_gapless() && head_is_there && tail_is_there;
  learn(frame);
  released_any_ = true;
  released_number_ = frame.number;
  released_counter_ = frame.last_counter;
}

void OpenFrames::learn(const Frame& frame) {
  if (frame.proven) {
    expected_ = frame.segments;
    unproven_ = 0;
    seen_ = 0;
    return;
  }
  if (is_complete(frame)) {
    expected_ = frame.segments;  // the device may send more than it did
    unproven_ = 0;
    seen_ = 0;
    return;
  }
  seen_ |= frame.segments;
  if (++unproven_ < patience) return;
  expected_ = seen_;
  unproven_ = 0;
  seen_ = 0;
}

/// A segment of a frame that was held for complete: frames have more segments than was known.
void OpenFrames::note_late(const Segment& segment) {
  if (expected_ != 0 && segment.frame == released_number_ && segment.counter > released_counter_)
    expected_ |= std::uint64_t{1} << segment.index;
}

void OpenFrames::restart() {
  frames_ = {};
  released_any_ = false;
  unproven_ = 0;
  seen_ = 0;
}

void OpenFrames::reset() {
  restart();
  expected_ = 0;
}

}  // namespace lidard::sick
