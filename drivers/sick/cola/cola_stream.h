// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/counters.h"
#include "drivers/stream_buffer.h"

namespace lidard::sick {

/// The two dialects of SICK's command language: A is text between STX and ETX, B binary with length and
/// checksum (SICK 8014631, "Telegram listing", chapter 2).
enum class ColaDialect : std::uint8_t { a, b };

/// The text between the frame's marks: "sSN LMDscandata ..." and the like.
struct ColaTelegram {
  ColaDialect dialect = ColaDialect::b;
  ByteView payload;

  /// "sSN", "sRA", "sFA" ...
  std::string_view kind() const { return payload.text().substr(0, 3); }
  /// "LMDscandata"; empty in an error answer.
  std::string_view name() const;
  /// The part behind the name and its blank.
  ByteView arguments() const;
};

/// Finds telegrams of both dialects in a byte stream that may begin anywhere and have holes.
///
/// A candidate is accepted only if length, command letters and checksum (B) or character set (A) fit, so that
/// measured values equal to a frame's mark do not start a frame. Memory is bounded by one telegram and one
/// chunk.
class ColaStream {
 public:
  /// The longest accepted payload, bytes; far more than any real one.
  static constexpr std::size_t longest = 256 * 1024UL;

  explicit ColaStream(Counters& counters) : counters_(counters) {}

  /// Appends bytes of the stream. Remove all telegrams before adding more.
  void add(ByteView bytes) { buffer_.add(bytes); }
  /// The next complete telegram, valid until the next call of add(), interrupt() or next().
  bool next(ColaTelegram& telegram);
  /// The stream begins or continues after a hole: drops the incomplete telegram.
  void interrupt();
  /// The checksum of dialect B: exclusive or of all payload bytes.
  static std::uint8_t checksum(ByteView payload);

 private:
  enum class Find : std::uint8_t { telegram, nothing, more };
  Find find_binary(ByteView rest, ColaTelegram& telegram, std::size_t& used);
  Find find_text(ByteView rest, ColaTelegram& telegram, std::size_t& used);
  void skip_byte();

  Counters& counters_;
  StreamBuffer buffer_;
  std::size_t searched_ = 0;  // text: bytes of the candidate without an end mark
  bool in_step_ = false;      // the last bytes were the end of a telegram
  bool joined_ = true;        // only an incomplete telegram was skipped since interrupt()
};

/// Reads the arguments of a binary telegram in order (SICK 8014631 chapter 2.3: big-endian). A missing value
/// makes ok() false and reads as 0.
class ColaBinaryReader {
 public:
  explicit ColaBinaryReader(ByteView bytes) : bytes_(bytes) {}

  bool ok() const { return ok_; }
  std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }
  std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
  std::uint32_t u32() { return number(4); }
  std::int16_t i16() { return static_cast<std::int16_t>(u16()); }
  std::int32_t i32() { return static_cast<std::int32_t>(u32()); }
  float f32();
  /// The length of a text: 16 bits in recorded telegrams, 8 bits in the manual of the LMS500 (SICK 8013796 p.
  /// 83). A first byte of 0 means 16 bits.
  std::size_t text_size();
  /// `size` characters; views into the telegram.
  std::string_view text(std::size_t size);
  /// `count` values of 8 or 16 bits.
  void values(std::size_t count, bool wide, std::vector<std::uint16_t>& out);
  /// Bytes left.
  std::size_t left() const { return bytes_.size() - at_; }
  /// The number of units of left() that a value of `bytes` bytes occupies.
  static constexpr std::size_t units(std::size_t bytes) { return bytes; }

 private:
  std::uint32_t number(std::size_t size);

  ByteView bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

/// Reads the arguments of a text telegram in order: fields separated by blanks, hexadecimal without a sign or
/// decimal with one (SICK 8014631 chapter 2.2).
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
  /// Fields left.
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

/// A flag, then the device's date and time if it is set.
template <class Reader>
void skip_time(Reader& in) {
  if (in.u16() == 0) return;
  in.u16();                             // year
  for (int i = 0; i < 5; ++i) in.u8();  // month ... second
  in.u32();                             // us
}

/// Writes one telegram: a command, then its arguments in order, then finish().
class ColaWriter {
 public:
  ColaWriter(ColaDialect dialect, std::string_view command);

  ColaWriter& u8(std::uint8_t value) { return put(value, 1); }
  ColaWriter& u16(std::uint16_t value) { return put(value, 2); }
  ColaWriter& u32(std::uint32_t value) { return put(value, 4); }
  ColaWriter& i32(std::int32_t value) { return put(static_cast<std::uint32_t>(value), 4); }
  /// A hash of eight digits: dialect A keeps leading zeros.
  ColaWriter& hash(std::uint32_t value);
  /// Characters without a length before them (channel names).
  ColaWriter& letters(std::string_view text);
  /// Returns the telegram with its frame.
  std::vector<std::uint8_t> finish();

 private:
  ColaWriter& put(std::uint32_t value, std::size_t size);
  void blank();

  ColaDialect dialect_;
  bool has_arguments_ = false;
  std::vector<std::uint8_t> bytes_;
};

/// The code of "sFA", or 0xff where it holds none.
std::uint8_t cola_error_code(const ColaTelegram& telegram);
/// Meaning of a refusal ("sFA" with that code), with the remedy.
std::string cola_error_words(std::uint8_t code);

}  // namespace lidard::sick
