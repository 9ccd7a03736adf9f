// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "daemon/config/config.h"

namespace lidard {

/// A copy of the last configuration that a daemon came up with, and of its calibrations, below
/// $STATE_DIRECTORY (systemd.exec(5)): what the next start uses instead of a file that is wrong. Without that
/// variable, as on a terminal, nothing is kept.
class LastGood {
 public:
  /// Of this configuration file.
  explicit LastGood(const std::string& config_file);

  /// Empty, or why it could not be kept.
  std::string keep(const Config& config) const;
  /// None, if there is no copy or it cannot be read.
  std::optional<Config> load() const;

 private:
  std::string folder_;  // empty: none
};

}  // namespace lidard
