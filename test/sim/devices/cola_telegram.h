// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace lidard::sim {

/// The two dialects of SICK's command language.
enum class Cola : std::uint8_t { text, binary };

/// Composes one telegram of either dialect: command, then values in order. Written from SICK 8014631
/// chapter 2, not from the program's own writer.
class ColaWords {
 public:
  ColaWords(Cola dialect, std::string command) : dialect_(dialect), payload_(std::move(command)) {}

  /// An unsigned number of so many bytes; of signed ones the two's complement.
  ColaWords& number(std::uint32_t value, int bytes);
  ColaWords& real(float value);
  /// Characters without a length, or behind one of so many bytes.
  ColaWords& letters(const std::string& text);
  ColaWords& text(const std::string& text, int length_bytes);
  /// The telegram in its frame.
  std::vector<std::uint8_t> bytes() const;
  /// The telegram without its frame.
  const std::string& payload() const { return payload_; }

 private:
  void separate();

  Cola dialect_;
  std::string payload_;
  bool has_values_ = false;
};

/// The arguments of a command as numbers of so many bytes each; in CoLa A hexadecimal, or decimal with a
/// sign. Empty if they are fewer, more, or no numbers.
std::optional<std::vector<std::uint32_t>> parse_numbers(Cola dialect, const std::string& arguments,
                                                        const std::vector<int>& widths);

struct SickChannel {
  std::string name = "DIST1";
  float scale = 1, offset = 0;
  std::int32_t start = -450000;  ///< 1/10000 deg
  std::uint16_t step = 5000;     ///< 1/10000 deg
  bool wide = true;              ///< 16 bits
  std::vector<std::uint16_t> values;
};

/// The telegram LMDscandata (SICK 8014631 chapter 4.3.4). The order of its fields is that of recorded
/// telegrams of an LMS111, LMS511, TiM781S and MRS1104 (CoLa B) and of an LMS5xx (CoLa A).
struct SickScan {
  std::string command = "sSN LMDscandata";
  std::uint16_t version = 1, device = 1;
  std::uint32_t serial = 12345678;
  std::uint8_t status[2] = {0, 0};
  std::uint16_t telegram_counter = 0, scan_counter = 0;
  std::uint32_t start_us = 0, transmit_us = 0;
  std::uint8_t inputs[2] = {0, 0}, outputs[2] = {0, 0};
  std::int16_t layer = 0;
  std::uint32_t scan_frequency = 5000;  ///< 1/100 Hz
  std::uint32_t measurement_frequency = 360;
  std::vector<std::pair<std::uint32_t, std::uint16_t>> encoders;
  std::vector<SickChannel> channels;
  bool position = false;
  std::string name, comment;
  std::optional<std::uint64_t> calendar_us;  ///< date and time since 1970-01-01, below a month
  bool event = false;

  std::vector<std::uint8_t> bytes(Cola dialect) const;
};

}  // namespace lidard::sim
