// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/driver.h"
#include "drivers/velodyne/web/velodyne_settings.h"
#include "drivers/velodyne/web/web_dialogue.h"

namespace lidard::velodyne {

/// What arrives from a sensor, to hold against what it reports.
struct Received {
  bool data = false;              ///< packets arrive now
  Endpoint destination;           ///< of the newest data packet
  const char* returns = nullptr;  ///< its return mode as the sensor spells it; nullptr: unknown
  std::optional<double> rpm;      ///< as the azimuths turn
  std::uint16_t listens_on = 0;   ///< the port we expect data on
};

/// Where a sensor's own report and what arrives differ, or why nothing arrives: sentences with the remedy,
/// the same as long as the matter is the same.
std::vector<std::string> contradictions(const WebState& state, const Received& received);

/// What a sensor's web interface tells, judged.
SettingsStatus web_status(const WebState& state, const Received& received);

}  // namespace lidard::velodyne
