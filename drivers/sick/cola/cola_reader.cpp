// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/sick/cola/cola_reader.h"

#include <algorithm>
#include <cstring>

namespace lidard::sick {
namespace {

float float_of_bits(std::uint32_t bits) {
  float value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

int digit_of(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : 99;
}

}  // namespace

std::uint32_t ColaBinaryReader::take(std::size_t size) {
  if (!bytes_.has(at_, size)) {
    ok_ = false;
    at_ = bytes_.size();
    return 0;
  }
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value = value << 8U | bytes_.data()[at_ + i];
  at_ += size;
  return value;
}

float ColaBinaryReader::f32() { return float_of_bits(take(4)); }

std::size_t ColaBinaryReader::text_size() {
  const std::uint8_t first = u8();
  return first != 0 ? first : u8();
}

std::string_view ColaBinaryReader::text(std::size_t size) {
  if (!bytes_.has(at_, size)) {
    ok_ = false;
    at_ = bytes_.size();
    return {};
  }
  const std::string_view found = bytes_.sub(at_, size).text();
  at_ += size;
  return found;
}

void ColaBinaryReader::values(std::size_t count, bool wide, std::vector<std::uint16_t>& out) {
  const std::size_t width = wide ? 2 : 1;
  out.clear();
  if (!bytes_.has(at_, count * width)) {
    ok_ = false;
    at_ = bytes_.size();
    return;
  }
  out.resize(count);
  const std::uint8_t* from = bytes_.data() + at_;
  for (std::size_t i = 0; i < count; ++i) {
    out[i] = wide ? static_cast<std::uint16_t>(from[2 * i] << 8U | from[2 * i + 1]) : from[i];
  }
  at_ += count * width;
}

std::string_view ColaTextReader::field() {
  while (!text_.empty() && text_.front() == ' ') text_.remove_prefix(1);
  const std::size_t end = std::min(text_.find(' '), text_.size());
  const std::string_view found = text_.substr(0, end);
  text_.remove_prefix(end);
  if (found.empty()) ok_ = false;
  return found;
}

/// Negative values come as the two's complement of their type, or with a sign.
std::uint32_t ColaTextReader::number(std::uint32_t highest) {
  std::string_view digits = field();
  const bool has_sign = !digits.empty() && (digits.front() == '+' || digits.front() == '-');
  const bool negative = has_sign && digits.front() == '-';
  if (has_sign) digits.remove_prefix(1);
  const int base = has_sign ? 10 : 16;
  std::uint64_t value = 0;
  if (digits.empty() || digits.size() > 10) ok_ = false;
  for (const char c : digits.substr(0, 10)) {
    const int digit = digit_of(c);
    if (digit >= base) ok_ = false;
    value = value * static_cast<std::uint64_t>(base) + static_cast<std::uint64_t>(digit);
  }
  if (value > highest) ok_ = false;
  if (!ok_) return 0;
  return static_cast<std::uint32_t>(negative ? 0 - value : value) & highest;
}

float ColaTextReader::f32() { return float_of_bits(number(0xffffffff)); }

/// A text follows its length and one blank, and may hold blanks itself.
std::string_view ColaTextReader::text(std::size_t size) {
  if (size == 0) return {};
  if (text_.size() < size + 1 || text_.front() != ' ') {
    // A name of fixed length is the first field of the telegram's arguments, or stands behind one blank.
    ok_ = false;
    return {};
  }
  const std::string_view found = text_.substr(1, size);
  text_.remove_prefix(size + 1);
  return found;
}

void ColaTextReader::values(std::size_t count, bool wide, std::vector<std::uint16_t>& out) {
  out.clear();
  // Every value takes two characters at least: a lying count asks for no memory.
  if (count > text_.size()) {
    ok_ = false;
    return;
  }
  out.resize(count);
  const std::uint32_t highest = wide ? 0xffff : 0xff;
  for (std::size_t i = 0; i < count && ok_; ++i) out[i] = static_cast<std::uint16_t>(number(highest));
}

std::size_t ColaTextReader::left() const {
  std::size_t fields = 0;
  bool inside = false;
  for (const char c : text_) {
    if (c != ' ' && !inside) ++fields;
    inside = c != ' ';
  }
  return fields;
}

}  // namespace lidard::sick
