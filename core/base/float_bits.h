// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>

namespace lidard {

/// The float or double (IEEE 754) of these bits.
template <class Float, class Bits>
Float float_of_bits(Bits bits) {
  static_assert(sizeof(Float) == sizeof(Bits));
  Float value = 0;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

}  // namespace lidard
