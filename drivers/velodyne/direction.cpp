// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/direction.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "core/base/angle.h"

namespace lidard::velodyne {
namespace {

constexpr int turn = 360;

using WholeDegrees = std::array<Direction, 2 * turn + 1>;  // from -360 to 360

WholeDegrees whole_degrees() {
  WholeDegrees table{};
  for (int i = -turn; i <= turn; ++i)
    table[static_cast<std::size_t>(i + turn)] = {std::cos(i * rad_per_deg), std::sin(i * rad_per_deg)};
  return table;
}

const WholeDegrees table = whole_degrees();

inline Direction direction_of(double angle_deg) {
  if (!(angle_deg > -turn && angle_deg < turn)) {
    return {std::cos(angle_deg * rad_per_deg), std::sin(angle_deg * rad_per_deg)};
  }
  const int place = static_cast<int>(angle_deg + (turn + 0.5));
  const Direction whole = table[static_cast<std::size_t>(place)];
  // Within half a degree the next terms of the series are below 1e-15.
  const double rest = (angle_deg - (place - turn)) * rad_per_deg;
  const double square = rest * rest;
  const double cosine = 1 - square * (1.0 / 2 - square * (1.0 / 24));
  const double sine = rest * (1 - square * (1.0 / 6 - square * (1.0 / 120)));
  return {whole.cosine * cosine - whole.sine * sine, whole.sine * cosine + whole.cosine * sine};
}

}  // namespace

Direction direction(double angle_deg) { return direction_of(angle_deg); }

void directions(const double* angles_deg, std::size_t count, Direction* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = direction_of(angles_deg[i]);
}

}  // namespace lidard::velodyne
