// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "core/base/time.h"

namespace lidard {

/// How a satellite receiver found its position.
enum class FixStatus : std::uint8_t {
  none,       ///< no position, or one that is not from satellites (dead reckoning, simulation, manual)
  satellite,  ///< satellites alone
  sbas,       ///< with differential corrections
  gbas        ///< with a base station's carrier phase (RTK)
};

/// A position that a satellite receiver wired to the device told.
struct GnssFix {
  std::string frame_id;
  Stamp stamp;                                                      ///< host time of the position
  double latitude_deg = std::numeric_limits<double>::quiet_NaN();   ///< WGS 84, north positive
  double longitude_deg = std::numeric_limits<double>::quiet_NaN();  ///< WGS 84, east positive
  double altitude_m = std::numeric_limits<double>::quiet_NaN();  ///< above the WGS 84 ellipsoid; NaN unknown
  FixStatus status = FixStatus::none;
  std::optional<Stamp> source_time;  ///< the receiver's own time (UTC), where it told the date too
};

/// One instant on two clocks.
struct TimeReference {
  Stamp stamp;         ///< on the host's clock
  Stamp reference;     ///< on the other clock (UTC)
  std::string source;  ///< which other clock
};

}  // namespace lidard
