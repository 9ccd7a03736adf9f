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

  friend bool operator==(const ColaOutputs& a, const ColaOutputs& b);
};

/// The echoes that come, "1+2", or "none".
std::string echoes_of(const ColaOutputs& outputs);
/// What differs, for people: "echoes 1 -> 1+2, output interval 1 -> 2".
std::string changes(const ColaOutputs& before, const ColaOutputs& now);

}  // namespace lidard::sick
