// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/hokuyo/uam_frame.h"

#include <algorithm>
#include <boost/crc.hpp>

#include "core/base/number_text.h"

namespace lidard::hokuyo {
namespace {

constexpr std::uint8_t stx = 0x02, etx = 0x03;
constexpr std::size_t shortest_frame = 14;     // a request without data
constexpr std::size_t longest_frame = 0x4000;  // the longest known one has 8703 bytes
constexpr std::size_t head = 5;                // STX and the length
constexpr std::size_t checksum_size = 5;       // CRC and ETX

}  // namespace

std::uint16_t uam_crc(std::string_view text) {
  boost::crc_optimal<16, 0x1021, 0, 0, true, true> crc;
  crc.process_bytes(text.data(), text.size());
  return crc.checksum();
}

std::string uam_request(std::string_view command) {
  const std::string text = printed("%04zX", command.size() + head + checksum_size) + std::string(command);
  return static_cast<char>(stx) + text + printed("%04X", uam_crc(text)) + static_cast<char>(etx);
}

std::optional<std::uint32_t> uam_number(std::string_view text, std::size_t at, std::size_t digits) {
  if (at > text.size() || digits > text.size() - at) return std::nullopt;
  return number_in<std::uint32_t>(text.substr(at, digits), 16);
}

UamReader::UamReader(Counters& counters) : counters_(counters) {}

void UamReader::interrupt() {
  if (begin_ < buffer_.size()) ++counters_.incomplete;
  buffer_.clear();
  begin_ = 0;
  torn_ = true;
}

void UamReader::add(ByteView bytes) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(begin_));
  begin_ = 0;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
}

/// Moves to the next STX; counts a torn frame's rest once.
bool UamReader::skip_to_frame() {
  const auto from = buffer_.begin() + static_cast<std::ptrdiff_t>(begin_);
  const auto start = std::find(from, buffer_.end(), stx);
  if (start != from && torn_) ++counters_.incomplete;
  if (start != from) torn_ = false;
  begin_ = static_cast<std::size_t>(start - buffer_.begin());
  return start != buffer_.end();
}

bool UamReader::next(std::string_view& frame) {
  while (skip_to_frame()) {
    const std::string_view rest(reinterpret_cast<const char*>(buffer_.data()) + begin_,
                                buffer_.size() - begin_);
    if (rest.size() < head) return false;
    const auto size = uam_number(rest, 1, 4);
    Reject reason = Reject::none;
    if (!size || *size < shortest_frame || *size > longest_frame) {
      reason = Reject::size;
    } else if (rest.size() < *size) {
      return false;
    } else if (static_cast<std::uint8_t>(rest[*size - 1]) != etx) {
      reason = Reject::magic;
    } else if (uam_number(rest, *size - checksum_size, 4) !=
               uam_crc(rest.substr(1, *size - 1 - checksum_size))) {
      reason = Reject::checksum;
    }
    torn_ = false;
    if (reason == Reject::none) {
      begin_ += *size;
      frame = rest.substr(0, *size);
      return true;
    }
    ++counters_.packets;
    counters_.reject(reason);
    ++begin_;  // a frame may begin inside of what only looked like one
  }
  return false;
}

}  // namespace lidard::hokuyo
