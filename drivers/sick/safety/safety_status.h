// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "drivers/sick/safety/ms3_telegram.h"

namespace lidard::sick {

/// What a safety scanner says about itself, small enough to be compared with each telegram: texts are made
/// only when something changed.
struct SafetyStatus {
  std::uint32_t serial = 0, plug_serial = 0;
  std::uint8_t channel = 0, version_major = 0, version_minor = 0, version_release = 0;
  std::optional<Ms3State> state;
  std::uint32_t intruded_paths = 0;
  std::uint8_t standby_state = 0;  ///< of the application outputs: 1 standby, 2 not, 0 not told

  /// The mirror does not turn.
  bool in_standby() const;
  friend bool operator==(const SafetyStatus& a, const SafetyStatus& b);
};

SafetyStatus read_status(const Ms3Telegram& telegram);

/// Key and text of everything known, for diagnostics.
std::vector<std::pair<std::string, std::string>> describe(const SafetyStatus& status);

}  // namespace lidard::sick
