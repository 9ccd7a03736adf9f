// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "core/frames/scan.h"

namespace lidard::hokuyo {

/// What distances below the shortest one mean; they are codes then, never distances.
enum class CodeTable : std::uint8_t {
  utm,  ///< Hokuyo C-42-03320B p. 12 table 4 (UTM-30LX); unverified for UST and UXM
  urg   ///< the same, table 3 (URG-04LX, UBG, UHG)
};

/// What a code says of its beam.
BeamStatus status_of_code(CodeTable table, std::uint32_t code);
/// The table that fits a product's name.
CodeTable code_table_of(std::string_view product);

/// The sensor's answer to PP (Hokuyo C-42-03320B p. 21), or what is known of a product beforehand.
struct ScipParameters {
  int range_min_mm = 0;    ///< DMIN; what is less is a code
  int range_max_mm = 0;    ///< DMAX; what is more is no echo
  int steps_per_turn = 0;  ///< ARES
  int first_step = 0;      ///< AMIN
  int last_step = 0;       ///< AMAX
  int front_step = 0;      ///< AFRT
  int rpm = 0;             ///< SCAN

  double rad_per_step() const;
  /// rad, counter-clockwise from the front; fractions of a step for groups.
  double angle(double step) const { return (step - front_step) * rad_per_step(); }
  double turn_seconds() const { return 60.0 / rpm; }
  double step_seconds() const { return turn_seconds() / steps_per_turn; }
  friend bool operator==(const ScipParameters& a, const ScipParameters& b);
};

/// Reads the lines of an answer to PP; `product` gets the sensor's name. False if a line is missing, its
/// checksum is wrong or the values make no sense.
bool parse_parameters(std::string_view body, ScipParameters& parameters, std::string& product);

/// Calls take(key, value) for each line KEY:VALUE of an answer to PP, VV or II. The checksum counts the line
/// without its semicolon; some firmware counts that, too. `sound` tells whether it is right.
template <class Take>
void for_each_entry(std::string_view body, Take&& take);

bool split_entry(std::string_view line, std::string_view& key, std::string_view& value, bool& sound);

template <class Take>
void for_each_entry(std::string_view body, Take&& take) {
  while (!body.empty()) {
    const std::size_t end = body.find('\n');
    std::string_view key, value;
    bool sound = false;
    if (split_entry(body.substr(0, end), key, value, sound)) take(key, value, sound);
    body.remove_prefix(end == std::string_view::npos ? body.size() : end + 1);
  }
}

}  // namespace lidard::hokuyo
