// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/counters.h"

namespace lidard {

const char* to_string(Reject reason) {
  constexpr std::array<const char*, reject_reasons> names = {
      "none", "size", "magic", "version", "checksum", "field", "model", "duplicate", "stale"};
  return names.at(static_cast<std::size_t>(reason));
}

}  // namespace lidard
