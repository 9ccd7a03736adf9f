// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/checksums.h"

#include <array>
#include <boost/crc.hpp>
#include <cstdio>
#include <string_view>

#include "drivers/hokuyo/scip_message.h"
#include "drivers/hokuyo/uam_frame.h"
#include "drivers/sick/compact/compact_telegram.h"

namespace lidard::sim {
namespace {

using Bytes = std::vector<std::uint8_t>;

bool mend_compact(Bytes& bytes) {
  const sick::TelegramHead head = sick::read_head({bytes.data(), bytes.size()});
  if (head.reject != Reject::none || head.length < 12 || head.length > bytes.size()) return false;
  boost::crc_32_type crc;
  const std::size_t skipped = head.type == sick::TelegramType::msgpack ? 8 : 0;
  crc.process_bytes(bytes.data() + skipped, head.length - 4 - skipped);
  for (unsigned i = 0; i < 4; ++i)
    bytes[head.length - 4 + i] = static_cast<std::uint8_t>(crc.checksum() >> 8 * i);
  return true;
}

/// STX four times, length (32 bit, big endian), payload, its bytes' exclusive or.
bool mend_cola(Bytes& bytes) {
  constexpr std::size_t head = 8;
  bool any = false;
  for (std::size_t at = 0; at + head < bytes.size();) {
    const ByteView rest(bytes.data() + at, bytes.size() - at);
    const std::size_t length = rest.be32(4);
    if (rest.be32(0) != 0x02020202 || !rest.has(head, length) || !rest.has(head + length, 1)) break;
    std::uint8_t sum = 0;
    for (const std::uint8_t byte : rest.sub(head, length)) sum = static_cast<std::uint8_t>(sum ^ byte);
    bytes[at + head + length] = sum;
    at += head + length + 1;
    any = true;
  }
  return any;
}

/// STX, length in four hexadecimal digits, payload, CRC in four, ETX.
bool mend_uam(Bytes& bytes) {
  bool any = false;
  for (std::size_t at = 0; at + 10 < bytes.size() && bytes[at] == 2;) {
    const std::string_view rest(reinterpret_cast<const char*>(bytes.data()) + at, bytes.size() - at);
    const auto size = hokuyo::uam_number(rest, 1, 4);
    if (!size || *size < 10 || *size > rest.size()) break;
    std::array<char, 8> crc{};
    std::snprintf(crc.data(), crc.size(), "%04X", hokuyo::uam_crc(rest.substr(1, *size - 6)));
    for (std::size_t i = 0; i < 4; ++i) bytes[at + *size - 5 + i] = static_cast<std::uint8_t>(crc[i]);
    at += *size;
    any = true;
  }
  return any;
}

/// The last character of a line sums up the others, but for the echo, the first line of an answer.
void mend_scip(Bytes& bytes) {
  bool echo = true;
  for (std::size_t at = 0; at < bytes.size();) {
    std::size_t end = at;
    while (end < bytes.size() && bytes[end] != '\n') ++end;
    const std::string_view line(reinterpret_cast<const char*>(bytes.data()) + at, end - at);
    if (!echo && line.size() > 1)
      bytes[end - 1] = static_cast<std::uint8_t>(hokuyo::scip_checksum(line.substr(0, line.size() - 1)));
    echo = line.empty();
    at = end + 1;
  }
}

}  // namespace

void make_checksums_right(std::vector<std::uint8_t>& bytes) {
  if (mend_compact(bytes) || mend_cola(bytes) || mend_uam(bytes)) return;
  if (bytes.size() > 1 && bytes[0] >= 'A' && bytes[0] <= 'Z') mend_scip(bytes);
}

}  // namespace lidard::sim
