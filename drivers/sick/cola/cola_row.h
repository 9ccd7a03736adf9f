// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string_view>

namespace lidard::sick {

/// Meaning of the telegram's "time since start up". SICK 8014631 says "time at the zero index before the
/// measurement itself starts"; the times of transmission beside it contradict that for some devices.
enum class ColaStamp : std::uint8_t { first_beam, last_beam };

/// What the answer to MCAngleCompSin means (sick_scan_xd 3.9.0, angle_compensator.cpp), a: the device's
/// angle. `subtracted`: a - A sin(a + P) - O (NAV2xx); `added`: a + A sin(a - P) + O (NAV3xx).
enum class AngleCompensation : std::uint8_t { none, subtracted, added };

/// Protocol properties of one device.
struct ColaRow {
  double shift_deg;              ///< added to the device's angle, so that 0 points ahead
  bool mirrored;                 ///< then the sign changes: the device counts clockwise
  ColaStamp stamp;               ///< meaning of the start time
  std::uint8_t turn;             ///< telegrams for each turn of the mirror
  std::uint8_t login;            ///< SOPAS user level that may write settings
  std::uint32_t password;        ///< its factory password, as SOPAS hashes it
  bool layered;                  ///< several planes, one telegram for each: a cloud
  std::uint8_t echoes = 1;       ///< bits of the echoes DIST1 ... that it can send
  bool zero_is_unknown = false;  ///< distance 0 does not say that nothing is there
  AngleCompensation compensation = AngleCompensation::none;
  bool reports_contamination =
      false;                  ///< answers LCMstate (SICK 8013796 p. 86; drivers of the LMS1xx ask it)
  std::string_view remark{};  ///< said once of a sensor: what sources disagree on
};

}  // namespace lidard::sick
