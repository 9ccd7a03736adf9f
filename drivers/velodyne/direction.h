// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace lidard::velodyne {

/// Cosine and sine of an angle.
struct Direction {
  double cosine, sine;
};

/// The direction of an angle in degrees, to 1e-15; quickest within a turn either way.
Direction direction(double angle_deg);
/// The directions of many angles: one takes a while, all together take little more.
void directions(const double* angles_deg, std::size_t count, Direction* to);

}  // namespace lidard::velodyne
