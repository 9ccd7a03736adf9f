// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/cloud.h"
#include "core/flatten.h"

namespace lidard {

/// Makes a virtual single-plane scan from a multi-plane cloud, as a scanner in the virtual frame would have
/// it.
class Virtualizer {
 public:
  Virtualizer(const ScanGrid& grid, HeightBand band) : flattener_(grid, band) {}

  /// The vehicle's outline in the virtual frame: points inside are left out.
  void set_footprint(const Footprint& footprint) { flattener_.set_footprint(footprint); }
  /// `virtual_from_cloud` takes the cloud's coordinates to the virtual frame. Stamp and frame period come
  /// from the cloud; the caller sets the frame's name.
  void project(const Cloud& cloud, const Pose& virtual_from_cloud, PlanarScan& scan);

 private:
  Flattener flattener_;
};

}  // namespace lidard
