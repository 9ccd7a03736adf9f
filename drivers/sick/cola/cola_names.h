// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "drivers/sick/cola/cola_scan.h"

namespace lidard::sick {

/// "output_1" ..., with static storage.
template <std::size_t Count>
class Names {
 public:
  Names(const char* before, const char* after) {
    for (std::size_t i = 0; i < Count; ++i) texts_[i] = before + std::to_string(i + 1) + after;
  }
  std::string_view operator[](std::size_t i) const { return texts_.at(i); }

 private:
  std::array<std::string, Count> texts_;
};

/// Names of the values in the messages beside the scans.
inline std::string_view field_name(std::uint8_t number) {
  static const Names<256> names("field_", "");
  return names[number == 0 ? 255 : number - 1U];
}

inline std::string_view pin_name(bool output, bool count, std::size_t i) {
  static const Names<ColaPins::most> outputs("output_", "");
  static const Names<ColaPins::most> counts("output_", "_count");
  static const Names<ColaPins::most> inputs("input_", "");
  if (!output) return inputs[i];
  return count ? counts[i] : outputs[i];
}

inline std::string_view encoder_name(bool speed, std::size_t i) {
  static const Names<ColaScan::most_encoders> positions("position_", "");
  static const Names<ColaScan::most_encoders> speeds("speed_", "");
  return speed ? speeds[i] : positions[i];
}

}  // namespace lidard::sick
