// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/counters.h"

namespace lidard::sick {

/// The two dialects of SICK's command language: A is text between STX and ETX, B binary with length and
/// checksum (SICK 8014631, "Telegram listing", chapter 2).
enum class ColaDialect : std::uint8_t { a, b };

/// What stands between the frame's marks: "sSN LMDscandata ..." and the like.
struct ColaTelegram {
  ColaDialect dialect = ColaDialect::b;
  ByteView payload;

  /// "sSN", "sRA", "sFA" ...
  std::string_view kind() const { return payload.text().substr(0, 3); }
  /// "LMDscandata"; empty in an error answer.
  std::string_view name() const;
  /// What follows the name and its blank.
  ByteView arguments() const;
};

/// Finds telegrams of both dialects in a byte stream that may begin anywhere and have holes.
///
/// A candidate counts only when length, command letters and checksum (B) or character set (A) fit, so that
/// measured values that look like a frame's mark are not taken for one. Memory is bounded by one telegram
/// and one chunk.
class ColaStream {
 public:
  /// The longest payload that is waited for, bytes. The largest real ones (several channels of a NAV or MRS
  /// in text) stay far below.
  static constexpr std::size_t longest = 256 * 1024;

  explicit ColaStream(Counters& counters) : counters_(counters) {}

  /// The next bytes of the stream. Take out all telegrams before adding more.
  void add(ByteView bytes);
  /// The next whole telegram, valid until the next call of add(), reset() or next().
  bool next(ColaTelegram& telegram);
  /// The stream begins or continues after a hole: what was begun will never be whole.
  void reset();
  /// The checksum of dialect B: all payload bytes, exclusive or.
  static std::uint8_t checksum(ByteView payload);

 private:
  enum class Find : std::uint8_t { telegram, nothing, more };
  Find find_binary(ByteView rest, ColaTelegram& telegram, std::size_t& used);
  Find find_text(ByteView rest, ColaTelegram& telegram, std::size_t& used);
  void skip_byte();

  Counters& counters_;
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;
  std::size_t searched_ = 0;  // text: this many bytes of the candidate hold no end
  bool in_step_ = false;      // the last thing was a telegram's end
  bool joined_ = true;        // nothing but a lost beginning was skipped since reset()
};

}  // namespace lidard::sick
