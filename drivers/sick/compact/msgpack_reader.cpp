// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/compact/msgpack_reader.h"

#include <cstring>

namespace lidard::sick {
namespace {

// Markers of the MessagePack specification (github.com/msgpack/msgpack, spec.md).
constexpr std::uint8_t fixmap = 0x80, fixarray = 0x90, fixstr = 0xa0;
constexpr std::uint8_t unused = 0xc1;
constexpr std::uint8_t bin8 = 0xc4, ext8 = 0xc7, float32 = 0xca, float64 = 0xcb;
constexpr std::uint8_t uint8 = 0xcc, int8 = 0xd0, fixext1 = 0xd4, str8 = 0xd9;
constexpr std::uint8_t array16 = 0xdc, map16 = 0xde;
constexpr std::uint8_t negative_fixint = 0xe0;

bool in(std::uint8_t marker, std::uint8_t first, std::size_t count) {
  return marker >= first && marker < first + count;
}

/// Bytes of the number behind a marker that is the n-th of 8, 16, 32, 64 bits.
std::size_t width_of(std::uint8_t marker, std::uint8_t first) { return 1U << (marker - first); }

}  // namespace

bool MsgpackReader::big(std::size_t width, std::uint64_t& value) {
  if (!has(width)) return false;
  value = 0;
  for (std::size_t i = 0; i < width; ++i) value = value << 8U | bytes_.u8(at_ + i);
  at_ += width;
  return true;
}

/// The number of what a map or an array holds; the markers of its kinds with 16 and 32 bits are neighbours.
bool MsgpackReader::count(std::uint8_t fix, std::uint8_t marker16, std::uint64_t& held) {
  if (!has(1)) return false;
  const std::uint8_t marker = bytes_.u8(at_++);
  held = marker & 0xfU;
  if (in(marker, fix, 16)) return true;
  return in(marker, marker16, 2) && big(marker == marker16 ? 2 : 4, held);
}

bool MsgpackReader::map(std::uint64_t& pairs) { return count(fixmap, map16, pairs); }
bool MsgpackReader::array(std::uint64_t& values) { return count(fixarray, array16, values); }

bool MsgpackReader::unsigned_integer(std::uint64_t& value) {
  if (!has(1)) return false;
  const std::uint8_t marker = bytes_.u8(at_++);
  if (marker < fixmap) {
    value = marker;
    return true;
  }
  if (in(marker, uint8, 4)) return big(width_of(marker, uint8), value);
  if (!in(marker, int8, 4)) return false;
  const std::size_t width = width_of(marker, int8);
  // A signed number that is not negative will do as well.
  return big(width, value) && value >> (8 * width - 1) == 0;
}

bool MsgpackReader::number(double& value) {
  if (!has(1)) return false;
  const std::uint8_t marker = bytes_.u8(at_);
  std::uint64_t raw = 0;
  if (marker == float32 || marker == float64) {
    ++at_;
    if (!big(marker == float32 ? 4 : 8, raw)) return false;
    float single = 0;
    const auto bits = static_cast<std::uint32_t>(raw);
    std::memcpy(&single, &bits, sizeof single);
    std::memcpy(&value, &raw, sizeof value);
    if (marker == float32) value = static_cast<double>(single);
    return true;
  }
  if (marker >= negative_fixint) {
    ++at_;
    value = static_cast<double>(marker) - 256;
    return true;
  }
  if (!unsigned_integer(raw)) return false;
  value = static_cast<double>(raw);
  return true;
}

bool MsgpackReader::binary(ByteView& value) {
  if (!has(1)) return false;
  const std::uint8_t marker = bytes_.u8(at_++);
  std::uint64_t length = 0;
  if (!in(marker, bin8, 3) || !big(width_of(marker, bin8), length) || !has(length)) return false;
  value = bytes_.sub(at_, length);
  at_ += length;
  return true;
}

bool MsgpackReader::next_is_map() const {
  if (!has(1)) return false;
  const std::uint8_t marker = bytes_.u8(at_);
  return in(marker, fixmap, 16) || in(marker, map16, 2);
}

/// Steps over one value; `inner` grows by the values that it holds.
bool MsgpackReader::skip_one(std::uint64_t& inner) {
  if (!has(1)) return false;
  const std::uint8_t marker = bytes_.u8(at_);
  std::uint64_t held = 0;
  const bool is_map = next_is_map();
  if (is_map || in(marker, fixarray, 16) || in(marker, array16, 2)) {
    if (!(is_map ? map(held) : array(held))) return false;
    inner += (is_map ? 2 : 1) * held;
    return true;
  }
  ++at_;
  std::uint64_t length = 0;
  if (in(marker, fixstr, 32)) length = marker & 0x1fU;
  if (in(marker, uint8, 4)) length = width_of(marker, uint8);
  if (in(marker, int8, 4)) length = width_of(marker, int8);
  if (marker == float32 || marker == float64) length = marker == float32 ? 4 : 8;
  if (in(marker, fixext1, 5)) length = width_of(marker, fixext1) + 1;
  if (in(marker, bin8, 3) && !big(width_of(marker, bin8), length)) return false;
  if (in(marker, str8, 3) && !big(width_of(marker, str8), length)) return false;
  if (in(marker, ext8, 3)) {
    if (!big(width_of(marker, ext8), length)) return false;
    ++length;
  }
  if (marker == unused || !has(length)) return false;
  at_ += length;
  return true;
}

bool MsgpackReader::skip() {
  std::uint64_t open = 1;
  while (open > 0) {
    --open;
    if (!skip_one(open)) return false;
    // Each value takes a byte: a count beyond what is left is a lie and must not be walked through.
    if (open > bytes_.size() - at_) return false;
  }
  return true;
}

}  // namespace lidard::sick
