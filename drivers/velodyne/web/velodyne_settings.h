// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/web_control.h"

namespace lidard {

/// One request that changes a setting.
struct VelodyneChange {
  std::string path;
  std::string body;
  std::string text;  ///< "rpm: 600 -> 1200"
};

struct VelodynePlan {
  std::string serial;                   ///< of the sensor; empty: not reported
  std::vector<VelodyneChange> changes;  ///< in the order of the requests
  std::vector<std::string> unknown;     ///< wanted settings that the sensor does not report
};

/// The changes from the settings in a sensor's `snapshot`, its answer to a request of all settings, to the
/// wanted ones. A setting that is not reported is not written, since it cannot be compared. Empty if the
/// snapshot is not a JSON object.
std::optional<VelodynePlan> plan(const std::string& snapshot, const VelodyneSettings& wanted);

}  // namespace lidard
