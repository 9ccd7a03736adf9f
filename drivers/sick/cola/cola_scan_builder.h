// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "core/frames/scan.h"
#include "drivers/driver.h"
#include "drivers/sick/cola/cola_geometry.h"

namespace lidard::sick {

/// Makes planar scans of the telegrams of a single-plane device.
class ColaScanBuilder {
 public:
  ColaScanBuilder(const DriverConfig& config, const ColaRow& row);

  /// Which beams the configured angles leave of this geometry. False: none.
  bool choose(const ColaGeometry& geometry);
  /// Beam of the telegram that comes first in the scan.
  std::size_t first_beam() const { return first_beam_; }
  /// The telegram's values in the chosen geometry; the stamp is the caller's.
  PlanarScan& fill(const ColaScan& telegram);

 private:
  void fill_echo(const ColaScan& telegram, std::size_t echo);

  const DriverConfig& config_;
  const ColaRow& row_;
  std::size_t first_beam_ = 0;
  std::size_t echoes_ = 1;
  PlanarScan scan_;
};

}  // namespace lidard::sick
