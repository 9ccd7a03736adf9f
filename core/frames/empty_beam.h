// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>

namespace lidard {

/// What stands in a beam of an output where nothing was seen.
enum class EmptyBeam : std::uint8_t { inf, nan, range_max_plus_one, minus_inf, zero };

/// The range that a message has for it; `range_max`: of the output, m.
inline float value_of(EmptyBeam beam, double range_max) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  switch (beam) {
    case EmptyBeam::inf:
      return infinite;
    case EmptyBeam::nan:
      return std::numeric_limits<float>::quiet_NaN();
    case EmptyBeam::range_max_plus_one:
      return static_cast<float>(range_max) + 1;
    case EmptyBeam::minus_inf:
      return -infinite;
    case EmptyBeam::zero:
      return 0;
  }
  return infinite;
}

}  // namespace lidard
