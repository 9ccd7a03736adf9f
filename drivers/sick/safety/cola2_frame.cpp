// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/safety/cola2_frame.h"

#include <algorithm>

namespace lidard::sick {
namespace {

// SICK 8022708 p. 28: four STX, length, then HubCntr, NoC, session, request, command, which the length
// counts.
constexpr std::uint8_t stx = 0x02;
constexpr std::size_t stx_count = 4;
constexpr std::size_t length_end = 8;
constexpr std::size_t counted_header = 10;
/// No variable known to us is longer; a longer length is a stream out of step.
constexpr std::size_t longest = 0x10000;

void put_be(std::vector<std::uint8_t>& out, std::uint32_t value, unsigned bytes) {
  while (bytes-- > 0) out.push_back(static_cast<std::uint8_t>(value >> (8U * bytes)));
}

}  // namespace

std::vector<std::uint8_t> encode_cola2(const Cola2Telegram& t) {
  std::vector<std::uint8_t> out(stx_count, stx);
  put_be(out, static_cast<std::uint32_t>(counted_header + t.data.size()), 4);
  put_be(out, 0, 2);
  put_be(out, t.session, 4);
  put_be(out, t.request, 2);
  out.push_back(static_cast<std::uint8_t>(t.type));
  out.push_back(static_cast<std::uint8_t>(t.mode));
  out.insert(out.end(), t.data.begin(), t.data.end());
  return out;
}

void Cola2Stream::clear() {
  buffer_.clear();
  used_ = 0;
}

void Cola2Stream::skip(std::size_t count) {
  skipped_ += count;
  drop(count);
}

void Cola2Stream::drop(std::size_t count) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(count));
}

std::size_t Cola2Stream::garbage() const {
  static constexpr std::uint8_t start[stx_count] = {stx, stx, stx, stx};
  const auto found = std::search(buffer_.begin(), buffer_.end(), std::begin(start), std::end(start));
  if (found != buffer_.end()) return static_cast<std::size_t>(found - buffer_.begin());
  // A shorter run of STX at the end may be the beginning of the next telegram.
  const auto run = std::find_if(buffer_.rbegin(), buffer_.rend(), [](std::uint8_t b) { return b != stx; });
  return static_cast<std::size_t>(buffer_.rend() - run);
}

bool Cola2Stream::next(Cola2Telegram& telegram) {
  drop(used_);
  used_ = 0;
  for (;;) {
    skip(garbage());
    const ByteView view(buffer_.data(), buffer_.size());
    if (!view.has(0, length_end)) return false;
    const std::size_t length = view.be32(stx_count);
    if (length < counted_header || length > longest) {
      skip(1);
      continue;
    }
    if (!view.has(length_end, length)) return false;
    telegram.session = view.be32(10);
    telegram.request = view.be16(14);
    telegram.type = static_cast<char>(view.u8(16));
    telegram.mode = static_cast<char>(view.u8(17));
    telegram.data = view.sub(length_end + counted_header, length - counted_header);
    used_ = length_end + length;
    return true;
  }
}

}  // namespace lidard::sick
