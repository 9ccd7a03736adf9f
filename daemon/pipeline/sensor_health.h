// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/pipeline/sensor_report.h"
#include "daemon/pipeline/sink.h"
#include "daemon/pipeline/unknown_senders.h"

namespace lidard {

/// A sensor's line on /diagnostics: is there data, as much as there should be, and if not, why probably not.
DiagnosticItem sensor_health(const SensorConfig& config, const SensorReport& report,
                             const UnknownSenders& unknown, Stamp now);

/// "sensor NAME control": what its driver tells of the device's settings.
DiagnosticItem settings_item(const SensorConfig& config, const SettingsStatus& status);

/// Names the senders on our ports that no sensor claims; there is at least one.
DiagnosticItem unknown_senders_item(const std::vector<std::string>& senders);

/// Where the data of a sensor come from, as configured: "192.168.1.201 to port 2368", "topic /rear/scan".
std::string where_from(const SensorConfig& config);

}  // namespace lidard
