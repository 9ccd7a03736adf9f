// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "drivers/sick/cola/cola_stream.h"

namespace lidard::sick {

/// Reads the arguments of a binary telegram one after the other (SICK 8014631 chapter 2.3: big-endian).
/// A value that is not there makes ok() false and reads as 0.
class ColaBinaryReader {
 public:
  explicit ColaBinaryReader(ByteView bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  std::uint8_t u8() { return static_cast<std::uint8_t>(take(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(take(2)); }
  std::uint32_t u32() { return take(4); }
  std::int16_t i16() { return static_cast<std::int16_t>(u16()); }
  std::int32_t i32() { return static_cast<std::int32_t>(u32()); }
  float f32();
  /// The number of characters of a text that follows: 16 bits in recorded telegrams, 8 in the manual of the
  /// LMS500 (SICK 8013796 p. 83); no text is so long that its first byte could be 0 in the latter.
  std::size_t text_size();
  /// `size` characters; views into the telegram.
  std::string_view text(std::size_t size);
  /// `count` values of 8 or 16 bits.
  void values(std::size_t count, bool wide, std::vector<std::uint16_t>& out);
  /// What is left: bytes.
  std::size_t left() const { return bytes_.size() - at_; }
  /// What a value of `bytes` bytes takes of left().
  static constexpr std::size_t units(std::size_t bytes) { return bytes; }

 private:
  std::uint32_t take(std::size_t size);

  ByteView bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

/// Reads the arguments of a text telegram one after the other: fields separated by blanks, hexadecimal
/// without a sign or decimal with one (SICK 8014631 chapter 2.2).
class ColaTextReader {
 public:
  explicit ColaTextReader(ByteView text) : text_(text.text()) {}

  bool ok() const { return ok_; }
  std::uint8_t u8() { return static_cast<std::uint8_t>(number(0xff)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(number(0xffff)); }
  std::uint32_t u32() { return number(0xffffffff); }
  std::int16_t i16() { return static_cast<std::int16_t>(u16()); }
  std::int32_t i32() { return static_cast<std::int32_t>(u32()); }
  float f32();
  std::size_t text_size() { return u16(); }
  std::string_view text(std::size_t size);
  void values(std::size_t count, bool wide, std::vector<std::uint16_t>& out);
  /// What is left: fields.
  std::size_t left() const;
  static constexpr std::size_t units(std::size_t) { return 1; }

 private:
  std::string_view field();
  std::uint32_t number(std::uint32_t highest);

  std::string_view text_;
  bool ok_ = true;
};

/// Calls read(reader) with the reader of the telegram's dialect.
template <class Read>
auto read_arguments(const ColaTelegram& telegram, Read&& read) {
  return telegram.dialect == ColaDialect::b ? read(ColaBinaryReader(telegram.arguments()))
                                            : read(ColaTextReader(telegram.arguments()));
}

}  // namespace lidard::sick
