// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "test/sim/devices/velodyne_layout.h"

namespace lidard::sim {

/// A part of the turn, clockwise from `start_deg` to `end_deg`, both included.
struct AzimuthSector {
  double start_deg = 0;
  double end_deg = 360;
};

struct VelodyneOptions {
  ReturnMode mode = ReturnMode::strongest;
  /// Turn per firing sequence. The product's default makes all azimuths exact on the wire (602.8 rpm on a
  /// VLP-16).
  std::optional<double> turn_deg;
  double start_azimuth_deg = 0;
  double telemetry_hz = 0;  ///< position packets per second; 0 none
  bool pps_locked = false;  ///< what the position packets say
  /// The device is silent outside. Its firings keep their rhythm and its packets fill up only here, so that
  /// one packet may hold firings from before and after the silence.
  std::optional<AzimuthSector> fov;
  std::string timing;                 ///< name of one of the product's; empty: the default
  std::int64_t rest_spread_ns = 700;  ///< a random rest differs from its mean by up to this
  bool old_stamp = false;     ///< HDL-32E before firmware 2.2.20: stamp of the last firing, no factory bytes
  bool status_stream = true;  ///< HDL-64E S2 and later: status bytes; else zeros
};

}  // namespace lidard::sim
