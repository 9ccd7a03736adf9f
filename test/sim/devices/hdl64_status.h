// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/time.h"
#include "test/sim/devices/velodyne_tables.h"

namespace lidard::sim {

/// What an HDL-64E says about itself, one byte per packet.
struct Hdl64State {
  bool s3 = false;    ///< S3 sends warning bits and a checksum
  bool dual = false;  ///< returns both echoes
  bool last = false;  ///< returns the last one
  bool synchronised = false;
  double rpm = 600;
};

/// The last two bytes of an HDL-64E's packets: 16 packets hold time, GPS, temperature, firmware and seven
/// bytes of calibration; 4160 packets hold all 1820 bytes of it.
class Hdl64Status {
 public:
  static constexpr std::size_t calibration_bytes = 1820;

  Hdl64Status(const VelodyneLasers& lasers, const Hdl64State& state);
  /// Type and value of packet `number` (from 0); `now`: the device's clock.
  std::array<std::uint8_t, 2> at(std::size_t number, Stamp now) const;
  /// The calibration as it is sent.
  const std::vector<std::uint8_t>& calibration() const { return calibration_; }

 private:
  std::array<std::uint8_t, 2> calibration_byte(std::size_t index) const;
  std::uint8_t warnings() const;

  Hdl64State state_;
  std::vector<std::uint8_t> calibration_;
};

}  // namespace lidard::sim
