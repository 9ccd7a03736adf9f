// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "daemon/config/config.h"

namespace lidard {

/// A copy of the last valid configuration of a daemon, with its calibrations, below $STATE_DIRECTORY
/// (systemd.exec(5)). The next start uses it if the file is invalid. Without that variable, as on a terminal,
/// no copy is kept.
class LastGood {
 public:
  /// The copy of this configuration file.
  explicit LastGood(const std::string& config_file);

  /// Empty, or why it could not be kept.
  std::string keep(const Config& config) const;
  /// nullopt if there is no readable copy.
  std::optional<Config> load() const;

 private:
  std::string folder_;  // empty: no copy is kept
};

}  // namespace lidard
