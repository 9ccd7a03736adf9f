// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/maker.h"

#include <limits>
#include <stdexcept>

namespace lidard {

ScanGrid grid_of(const ScanGridSpec& spec) {
  const auto grid = make_grid(spec);
  if (!grid) throw std::logic_error("configuration accepted a grid that is wrong: " + grid.reason());
  return *grid;
}

HeightBand band_of(const OutputScanConfig& config) {
  HeightBand band;
  if (config.min_height) band.min = *config.min_height;
  if (config.max_height) band.max = *config.max_height;
  return band;
}

float value_of(EmptyBeam beam, const OutputScanConfig& config) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  switch (beam) {
    case EmptyBeam::inf:
      return infinite;
    case EmptyBeam::nan:
      return std::numeric_limits<float>::quiet_NaN();
    case EmptyBeam::range_max_plus_one:
      return static_cast<float>(config.grid.range_max) + 1;
    case EmptyBeam::minus_inf:
      return -infinite;
    case EmptyBeam::zero:
      return 0;
  }
  return infinite;
}

void set_encoding(const OutputScanConfig& output, PlanarScan& scan) {
  scan.none_as = value_of(output.empty, output);
  scan.invalid_as = value_of(output.unobserved, output);
}

}  // namespace lidard
