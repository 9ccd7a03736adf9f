// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/sick/cola/cola_stream.h"

namespace lidard::sick {

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
  /// The telegram with its frame.
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
/// What a refusal ("sFA" with that code) means and what to do about it.
std::string cola_error_words(std::uint8_t code);

}  // namespace lidard::sick
