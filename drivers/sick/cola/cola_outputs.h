// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace lidard::sick {

/// LMDscandatacfg: what the device puts into its scans (SICK 8014631 chapter 4.3.1).
struct ColaOutputs {
  std::array<std::uint8_t, 2> channels{};  ///< bit by echo
  std::uint8_t rssi = 0, wide_rssi = 0, unit = 0;
  std::array<std::uint8_t, 2> encoders{};
  std::uint8_t position = 0, name = 0, comment = 0, time = 0;
  std::uint16_t interval = 1;  ///< every n-th scan

  friend bool operator==(const ColaOutputs& a, const ColaOutputs& b) {
    return a.channels == b.channels && a.rssi == b.rssi && a.wide_rssi == b.wide_rssi && a.unit == b.unit &&
           a.encoders == b.encoders && a.position == b.position && a.name == b.name &&
           a.comment == b.comment && a.time == b.time && a.interval == b.interval;
  }
};

/// The echoes that come, "1+2", or "none".
inline std::string echoes_of(const ColaOutputs& s) {
  std::string text;
  for (unsigned bit = 0; bit < 5; ++bit) {
    if ((s.channels[0] >> bit & 1U) != 0) text += (text.empty() ? "" : "+") + std::to_string(bit + 1);
  }
  return text.empty() ? "none" : text;
}

/// What differs, for people: "echoes 1 -> 1+2, output interval 1 -> 2".
inline std::string changes(const ColaOutputs& before, const ColaOutputs& now) {
  std::string text;
  const auto append = [&text](const char* what, const std::string& was, const std::string& is) {
    if (was == is) return;
    text += (text.empty() ? "" : ", ") + std::string(what) + " " + was + " -> " + is;
  };
  const auto on_off = [](bool on) { return std::string(on ? "on" : "off"); };
  append("echoes", echoes_of(before), echoes_of(now));
  append("intensity", on_off(before.rssi != 0), on_off(now.rssi != 0));
  append("output interval", std::to_string(before.interval), std::to_string(now.interval));
  return text;
}

}  // namespace lidard::sick
