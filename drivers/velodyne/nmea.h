// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "core/base/time.h"
#include "core/frames/device_message.h"

namespace lidard::velodyne {

/// What a sentence is good for; only `valid` may be believed.
enum class NmeaVerdict : std::uint8_t {
  absent,          ///< no text
  malformed,       ///< no sentence, or a field holds what cannot be
  bad_checksum,    ///< checksum wrong or missing
  other_sentence,  ///< neither RMC nor GGA
  no_fix,          ///< the receiver itself says so (RMC status V, GGA quality 0) or guesses its position
  invented_date,   ///< 2000 or before: what an HDL-32E without a receiver sends
  valid,
  count_
};

/// The sentences that Velodyne sensors take from a receiver and hand on.
enum class NmeaKind : std::uint8_t { none, rmc, gga };

/// One sentence. The values below `verdict` mean something only if it is valid.
struct NmeaReading {
  NmeaVerdict verdict = NmeaVerdict::absent;
  NmeaKind kind = NmeaKind::none;
  Span time_of_day{0};       ///< since midnight UTC
  std::optional<Stamp> utc;  ///< RMC only: GGA has no date
  FixStatus status = FixStatus::none;
  double latitude_deg = std::numeric_limits<double>::quiet_NaN();
  double longitude_deg = std::numeric_limits<double>::quiet_NaN();
  double altitude_m = std::numeric_limits<double>::quiet_NaN();  ///< above the ellipsoid; GGA with geoid only
};

/// Reads `$..RMC` and `$..GGA` of any talker (NMEA 0183), up to the first NUL, CR or LF. Never throws.
NmeaReading read_nmea(std::string_view text);

}  // namespace lidard::velodyne
