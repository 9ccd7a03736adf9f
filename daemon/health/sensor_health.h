// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/health/diagnostics.h"
#include "daemon/pipeline/status.h"

namespace lidard {

/// A sensor's item on /diagnostics: the amount of data and, if it is too small, the probable cause.
DiagnosticItem sensor_health(const SensorStatus& report, const UnknownSenders& unknown, Stamp now);

/// The item on senders to configured ports that belong to no sensor; at least one.
DiagnosticItem unknown_senders_item(const std::vector<std::string>& senders);

/// The configured source of a sensor's data: "192.168.1.201 to port 2368", "topic /rear/scan".
std::string where_from(const SensorConfig& config);

}  // namespace lidard
