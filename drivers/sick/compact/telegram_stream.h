// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/base/counters.h"
#include "drivers/sick/compact/compact_telegram.h"

namespace lidard::sick {

/// Finds whole telegrams in a stream of bytes, joined anywhere and with holes: looks for the start mark again
/// wherever the bytes are no telegram with a right checksum.
class TelegramStream {
 public:
  /// Takes the next bytes and calls `take(telegram, type)` for each telegram that is whole; the view is valid
  /// during the call. Returns the last reason for which bytes were skipped inside what looked like a stream.
  template <class Take>
  Reject feed(ByteView chunk, Counters& counters, Take&& take);
  /// Bytes are missing, or the connection ended: half a telegram is worth nothing.
  void cut(Counters& counters);
  /// Times that the start mark had to be looked for again.
  std::uint64_t resyncs() const { return resyncs_; }

 private:
  ByteView rest() const { return {buffer_.data() + at_, buffer_.size() - at_}; }
  void append(ByteView chunk);
  void skip_to_mark();

  std::vector<std::uint8_t> buffer_;
  std::size_t at_ = 0;
  bool in_step_ = false;  // the last telegram ended at at_
  std::uint64_t resyncs_ = 0;
};

template <class Take>
Reject TelegramStream::feed(ByteView chunk, Counters& counters, Take&& take) {
  append(chunk);
  Reject last = Reject::none;
  for (;;) {
    const TelegramHead head = read_head(rest());
    Reject reason = head.reject;
    if (reason == Reject::none) {
      if (head.length == 0 || head.length > rest().size()) return last;
      const ByteView telegram = rest().sub(0, head.length);
      if (checksum_is_right(telegram, head.type)) {
        at_ += head.length;
        in_step_ = true;
        take(telegram, head.type);
        continue;
      }
      reason = Reject::checksum;
    }
    // Before the first telegram and behind a hole nothing else is to be expected.
    if (in_step_) {
      counters.reject(reason);
      last = reason;
      ++resyncs_;
    }
    in_step_ = false;
    skip_to_mark();
  }
}

}  // namespace lidard::sick
