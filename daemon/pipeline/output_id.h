// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

namespace lidard {

/// An entry of merged_scans: or virtual_scans: of the configuration.
struct OutputId {
  enum class Kind : std::uint8_t { merged, virtual_group };
  Kind kind = Kind::merged;
  std::string entry;

  friend bool operator==(const OutputId& a, const OutputId& b) {
    return a.kind == b.kind && a.entry == b.entry;
  }
};

}  // namespace lidard
