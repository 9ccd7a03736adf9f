// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidard {

/// The length, m, of one step of distance of a FreeSpaceMap that tells ways as far as `range_max` (m) from
/// the output's origin; sources that stand more than 100 m away from it see nothing of it.
constexpr double profile_unit(double range_max) { return (range_max + 100) / 60000; }

}  // namespace lidard
