// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "drivers/driver.h"
#include "drivers/velodyne/web/velodyne_settings.h"
#include "drivers/velodyne/web/web_dialogue.h"

namespace lidard::velodyne {

/// The received data of a sensor, for comparison with its report.
struct Received {
  bool data = false;             ///< packets are arriving
  Endpoint destination;          ///< of the newest data packet
  std::uint16_t listens_on = 0;  ///< the local port of the data
};

/// Differences between a sensor's report and the received data, or why no data arrives: sentences with the
/// remedy, stable while the cause lasts.
std::vector<std::string> contradictions(const WebState& state, const Received& received);

/// The status from a sensor's web interface.
SettingsStatus web_status(const WebState& state, const Received& received);

}  // namespace lidard::velodyne
