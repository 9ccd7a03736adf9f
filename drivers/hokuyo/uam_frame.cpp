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

void UamReader::interrupt() {
  if (!buffer_.rest().empty()) ++counters_.incomplete;
  buffer_.clear();
  torn_ = true;
}

/// Moves to the next STX; counts a torn frame's rest once.
bool UamReader::skip_to_frame() {
  const std::string_view rest = buffer_.rest().text();
  const std::size_t start = std::min(rest.find(static_cast<char>(stx)), rest.size());
  if (start > 0 && torn_) ++counters_.incomplete;
  if (start > 0) torn_ = false;
  buffer_.drop(start);
  return start < rest.size();
}

bool UamReader::next(UamFrame& frame) {
  if (!skip_to_frame()) return false;
  const std::string_view rest = buffer_.rest().text();
  if (rest.size() < head) return false;
  const auto size = uam_number(rest, 1, 4);
  frame = {};
  if (!size || *size < shortest_frame || *size > longest_frame) {
    frame.reject = Reject::size;
  } else if (rest.size() < *size) {
    return false;
  } else if (static_cast<std::uint8_t>(rest[*size - 1]) != etx) {
    frame.reject = Reject::magic;
  } else if (uam_number(rest, *size - checksum_size, 4) !=
             uam_crc(rest.substr(1, *size - 1 - checksum_size))) {
    frame.reject = Reject::checksum;
  } else {
    frame.text = rest.substr(0, *size);
  }
  torn_ = false;
  // A frame may begin inside a false one.
  buffer_.drop(frame.reject == Reject::none ? *size : 1);
  return true;
}

}  // namespace lidard::hokuyo
