// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_stream.h"

#include <algorithm>

namespace lidard::sick {
namespace {

// SICK 8014631 chapter 2: frames of both dialects.
constexpr std::uint8_t stx = 2;
constexpr std::uint8_t etx = 3;
constexpr std::size_t marks = 4;        // STX four times
constexpr std::size_t binary_head = 8;  // marks and length
constexpr std::size_t letters = 3;      // "sSN": the shortest that tells a command

bool is_upper(std::uint8_t c) { return c >= 'A' && c <= 'Z'; }

/// True as long as nothing contradicts that a command ("sRN", "sFA") begins at `at`.
bool may_be_command(ByteView bytes, std::size_t at) {
  if (bytes.has(at, 1) && bytes.data()[at] != 's') return false;
  if (bytes.has(at + 1, 1) && !is_upper(bytes.data()[at + 1])) return false;
  return !bytes.has(at + 2, 1) || is_upper(bytes.data()[at + 2]);
}

}  // namespace

std::string_view ColaTelegram::name() const {
  const std::string_view text = payload.text();
  if (text.size() < 5 || text[3] != ' ') return {};
  const std::size_t end = text.find(' ', 4);
  return text.substr(4, end == std::string_view::npos ? end : end - 4);
}

ByteView ColaTelegram::arguments() const {
  const std::size_t begin = 4 + name().size() + 1;
  return begin < payload.size() ? payload.from(begin) : ByteView();
}

std::uint8_t ColaStream::checksum(ByteView payload) {
  std::uint8_t sum = 0;
  for (const std::uint8_t byte : payload) sum = static_cast<std::uint8_t>(sum ^ byte);
  return sum;
}

void ColaStream::add(ByteView bytes) {
  if (begin_ > 0) {
    buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
    begin_ = 0;
  }
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

void ColaStream::reset() {
  if (begin_ < buffer_.size()) ++counters_.incomplete;
  buffer_.clear();
  begin_ = 0;
  searched_ = 0;
  in_step_ = false;
  joined_ = true;
}

/// Counts once for every row of bytes that belong to no telegram.
void ColaStream::skip_byte() {
  if (in_step_) {
    counters_.reject(Reject::magic);
  } else if (joined_) {
    ++counters_.incomplete;
  }
  in_step_ = false;
  joined_ = false;
  searched_ = 0;
  ++begin_;
}

bool ColaStream::next(ColaTelegram& telegram) {
  while (begin_ < buffer_.size()) {
    const ByteView rest(buffer_.data() + begin_, buffer_.size() - begin_);
    Find found = Find::nothing;
    std::size_t used = 0;
    if (rest.u8(0) == stx) {
      const bool text = rest.has(1, 1) && rest.u8(1) == 's';
      found = text ? find_text(rest, telegram, used) : find_binary(rest, telegram, used);
    }
    if (found == Find::more) return false;
    if (found == Find::telegram) {
      begin_ += used;
      searched_ = 0;
      in_step_ = true;
      joined_ = false;
      return true;
    }
    skip_byte();
  }
  return false;
}

ColaStream::Find ColaStream::find_binary(ByteView rest, ColaTelegram& telegram, std::size_t& used) {
  for (std::size_t i = 0; i < std::min(marks, rest.size()); ++i) {
    if (rest.u8(i) != stx) return Find::nothing;
  }
  if (!may_be_command(rest, binary_head)) return Find::nothing;
  if (!rest.has(0, binary_head)) return Find::more;
  const std::size_t length = rest.be32(marks);
  if (length < letters || length > longest) return Find::nothing;
  if (!rest.has(binary_head, length + 1)) return Find::more;
  const ByteView payload = rest.sub(binary_head, length);
  if (checksum(payload) != rest.u8(binary_head + length)) {
    // A length that was damaged may reach over good telegrams: only the mark is given up.
    counters_.reject(Reject::checksum);
    in_step_ = false;
    joined_ = false;
    return Find::nothing;
  }
  telegram = {ColaDialect::b, payload};
  used = binary_head + length + 1;
  return Find::telegram;
}

ColaStream::Find ColaStream::find_text(ByteView rest, ColaTelegram& telegram, std::size_t& used) {
  if (!may_be_command(rest, 1)) return Find::nothing;
  std::size_t end = std::max<std::size_t>(1, searched_);
  while (end < rest.size() && rest.data()[end] >= ' ') ++end;
  if (end > longest) return Find::nothing;
  if (end == rest.size()) {
    searched_ = end;
    return Find::more;
  }
  if (rest.u8(end) != etx || end < 1 + letters) return Find::nothing;
  telegram = {ColaDialect::a, rest.sub(1, end - 1)};
  used = end + 1;
  return Find::telegram;
}

}  // namespace lidard::sick
