// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/recognizer.h"

namespace lidard::acme {

/// The Disc 270, a planar lidar that does not exist, and its protocol, which was invented for this driver:
/// the smallest whole driver, to be copied by whoever writes one. Of a real device each of these lines names
/// the manual, the capture or the vendor's code that it comes from.
///
/// The mirror turns 25 times a second. A scan has 720 beams, counter-clockwise from -135 deg in steps of
/// 0.375 deg, and travels in four datagrams, each sent when its last beam was measured. All numbers are
/// little endian.
///
///     offset  bytes  meaning
///          0      4  "DISC"
///          4      1  version of the protocol: 1
///          5      1  part of the scan, 0 to 3
///          6      2  number of the scan; overflows
///          8      4  serial number
///         12      4  device time of the scan's first beam in us; overflows every 71 minutes
///         16      2  bit 0: the window is dirty
///         18    360  distances of 180 beams in mm; 0: nothing came back, 1: too near, 65535: not measured
namespace disc {
constexpr std::uint16_t port = 5270;
constexpr std::size_t parts = 4, beams_of_part = 180, beams = parts * beams_of_part;
constexpr std::size_t header_size = 18, packet_size = header_size + 2 * beams_of_part;
constexpr double first_deg = -135, step_deg = 0.375;
constexpr Span turn = std::chrono::milliseconds(40), beam = turn / 960;  ///< 960 steps are a whole turn
constexpr std::uint16_t nothing = 0, too_near = 1, not_measured = 65535;
}  // namespace disc

/// What makes the model known: register_family(disc_family).
extern const Family disc_family;

}  // namespace lidard::acme
