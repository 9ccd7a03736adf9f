// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/commands/replay.h"

namespace lidard {

/// What the parameters of another package's node ask for.
struct DropinSetup {
  std::string yaml;                   ///< the configuration that does the same
  ReplayOptions replay;               ///< of a capture; without captures: live
  std::vector<std::string> warnings;  ///< of values that were changed and of parameters without effect
};

}  // namespace lidard
