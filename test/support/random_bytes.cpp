// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/random_bytes.h"

#include <vector>

#include "core/base/angle.h"
#include "test/sim/world/units.h"

namespace lidard::sim {

ScanGrid read_grid(Bytes& in) {
  ScanGridSpec spec;
  spec.beams = 2 + in.below(2000);
  if (in.chance(100))
    spec.angle_min = in.between(-pi_d, 0), spec.angle_max = spec.angle_min + in.between(0.1, pi_d);
  spec.range_max = in.between(0.5, 80);
  if (in.chance(60)) spec.range_min = in.between(0, 0.4);
  const auto grid = make_grid(spec);
  if (!grid) std::abort();
  return *grid;
}

HeightBand read_band(Bytes& in) {
  HeightBand band;
  if (in.chance(80)) band.min = in.between(-1, 0.2), band.max = band.min + in.between(0, 1);
  return band;
}

Pose read_pose(Bytes& in) {
  const double tilt = in.chance(100) ? pi_d : 0.05;
  return make_pose({in.between(-5, 5), in.between(-5, 5), in.between(-1, 1)},
                   {in.between(-tilt, tilt), in.between(-tilt, tilt), in.between(-pi_d, pi_d)});
}

Footprint read_footprint(Bytes& in) {
  std::vector<Eigen::Vector2d> corners;
  for (std::size_t n = in.below(7); n > 0; --n) corners.emplace_back(in.between(-4, 4), in.between(-2, 2));
  return Footprint(corners);
}

void check(const PlanarScan& scan, const ScanGrid& grid) {
  if (violation(scan) != nullptr || scan.beams != grid.beams) std::abort();
}

}  // namespace lidard::sim
