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

/// Validity of a sentence; only `valid` may be used.
enum class NmeaVerdict : std::uint8_t {
  absent,          ///< no text
  malformed,       ///< not a sentence, or an impossible field
  bad_checksum,    ///< checksum wrong or missing
  other_sentence,  ///< neither RMC nor GGA
  no_fix,          ///< reported by the receiver (RMC status V, GGA quality 0), or an estimated position
  invented_date,   ///< 2000 or before: sent by an HDL-32E without a receiver
  valid,
  count_
};

/// The sentences that Velodyne sensors forward from a receiver.
enum class NmeaKind : std::uint8_t { none, rmc, gga };

/// One sentence. The members after `verdict` are set only if it is valid.
struct NmeaReading {
  NmeaVerdict verdict = NmeaVerdict::absent;
  NmeaKind kind = NmeaKind::none;
  Span time_of_day{0};           ///< since midnight UTC
  std::optional<HostStamp> utc;  ///< RMC only: GGA has no date
  FixStatus status = FixStatus::none;
  double latitude_deg = std::numeric_limits<double>::quiet_NaN();
  double longitude_deg = std::numeric_limits<double>::quiet_NaN();
  double altitude_m = std::numeric_limits<double>::quiet_NaN();  ///< above the ellipsoid; GGA with geoid only
};

/// Reads `$..RMC` and `$..GGA` of any talker (NMEA 0183), up to the first NUL, CR or LF. Never throws.
NmeaReading read_nmea(std::string_view text);

}  // namespace lidard::velodyne
