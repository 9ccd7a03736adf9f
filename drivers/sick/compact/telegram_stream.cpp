// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/compact/telegram_stream.h"

#include <algorithm>

namespace lidard::sick {
namespace {

constexpr std::uint8_t mark_byte = 0x02;

}  // namespace

void TelegramStream::append(ByteView chunk) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(at_));
  at_ = 0;
  buffer_.insert(buffer_.end(), chunk.begin(), chunk.end());
}

/// Steps over at least one byte, to the next that may begin a start mark.
void TelegramStream::skip_to_mark() {
  if (rest().empty()) return;
  const auto from = buffer_.begin() + static_cast<std::ptrdiff_t>(at_) + 1;
  at_ = static_cast<std::size_t>(std::find(from, buffer_.end(), mark_byte) - buffer_.begin());
}

void TelegramStream::cut(Counters& counters) {
  if (in_step_ && !rest().empty()) ++counters.incomplete;
  buffer_.clear();
  at_ = 0;
  in_step_ = false;
}

}  // namespace lidard::sick
