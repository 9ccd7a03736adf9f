// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "core/base/pose.h"
#include "core/evidence/beam_rays.h"
#include "core/frames/scan.h"
#include "core/frames/scan_grid.h"

namespace lidard::sim {

/// Values out of bytes, as a fuzzer or a generator of random numbers makes them; zeros when there are no
/// more.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  bool empty() const { return left_ == 0; }
  std::uint8_t byte() {
    if (left_ == 0) return 0;
    --left_;
    return *data_++;
  }
  std::size_t below(std::size_t n) { return (byte() | static_cast<std::size_t>(byte()) << 8U) % n; }
  bool chance(unsigned of_256) { return byte() < of_256; }
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(below(65536)) / 65535;
  }
  float any_float() {
    const std::uint32_t bits =
        static_cast<std::uint32_t>(below(65536)) << 16U | static_cast<std::uint32_t>(below(65536));
    float value;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

ScanGrid read_grid(Bytes& in);
HeightBand read_band(Bytes& in);
Pose read_pose(Bytes& in);
Footprint read_footprint(Bytes& in);
/// Ends the process if an output breaks an invariant of scans.
void check(const PlanarScan& scan, const ScanGrid& grid);

}  // namespace lidard::sim
