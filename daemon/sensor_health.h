// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/pipeline.h"

namespace lidard {

/// A sensor's line on /diagnostics: is there data, as much as there should be, and if not, why probably not.
DiagnosticItem sensor_health(const SensorConfig& config, const SensorReport& report,
                             const std::vector<std::string>& unclaimed_senders, Stamp now);

/// Names the senders on our ports that no sensor claims; there is at least one.
DiagnosticItem unknown_senders_item(const std::vector<std::string>& senders);

}  // namespace lidard
