// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config_parts.h"

namespace lidard {

/// Between which ranges a source measures, m.
struct SourceLimits {
  SourceLimits(const SensorConfig* sensor);
  SourceLimits(const ScanGridSpec& grid) : range_min(grid.range_min), range_max(grid.range_max) {}

  double range_min, range_max;
};
using Sources = std::vector<SourceLimits>;

constexpr double longest_period_s = 3600;

/// `keys` and those that merged and virtual scans share.
std::vector<std::string_view> with_output_keys(std::vector<std::string_view> keys);
/// The keys that merged and virtual scans share; `output` holds the defaults of the kind.
void read_output(Mapping& yaml, const Sources& sources, Config& config, OutputScanConfig& output);

}  // namespace lidard
