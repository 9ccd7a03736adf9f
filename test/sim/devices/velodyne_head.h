// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/base/time.h"
#include "test/sim/devices/velodyne_options.h"
#include "test/sim/devices/velodyne_tables.h"
#include "test/sim/world/rng.h"

namespace lidard::sim {

/// The rotating part: where it looks at any time, and when its firing sequences begin.
class VelodyneHead {
 public:
  /// `group`: firing sequences that share an azimuth on the wire; they are sent or hidden together.
  /// `step_deg`: of the azimuth on the wire, which the head has passed; 0: hundredths of a degree, rounded.
  VelodyneHead(const VelodyneTiming& timing, const VelodyneOptions& options, std::size_t group,
               double step_deg, Stamp start);

  /// Exact, in [0, 360).
  double azimuth_deg(Stamp time) const;
  /// As on the wire: 1/100 deg in 0..35999.
  std::uint16_t wire_azimuth(Stamp time) const;
  /// Begin of the next group of sequences that is sent.
  Stamp next_group();

 private:
  bool visible(Stamp time) const;
  std::int64_t rest();

  const VelodyneTiming& timing_;
  double turn_deg_;
  double start_deg_;
  std::optional<AzimuthSector> fov_;
  std::int64_t rest_spread_ns_;
  std::size_t group_;
  double step_deg_;
  Stamp start_;
  Stamp next_;
  Rng rng_;
};

}  // namespace lidard::sim
