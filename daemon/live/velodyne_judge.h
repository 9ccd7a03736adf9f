// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/live/velodyne_http.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// What arrives from a sensor, to hold against what it reports.
struct VelodyneReceived {
  bool data = false;             ///< packets arrive now
  Endpoint destination;          ///< of the newest data packet
  std::uint8_t mode = 0;         ///< its return-mode byte
  std::optional<double> rpm;     ///< as the azimuths turn
  std::uint16_t listens_on = 0;  ///< the port we expect data on
};

/// Where a sensor's own report and what arrives differ, or why nothing arrives: sentences with the remedy,
/// the same as long as the matter is the same.
std::vector<std::string> contradictions(const VelodyneHttpState& state, const VelodyneReceived& received);

/// The status "sensor NAME control" for /diagnostics.
DiagnosticItem velodyne_control_item(const std::string& sensor, const VelodyneHttpState& state,
                                     const VelodyneReceived& received);

}  // namespace lidard
