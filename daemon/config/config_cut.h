// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/config_parts.h"

namespace lidard {

/// The keys that read_cut() reads.
extern const std::vector<std::string_view> cut_keys;
/// The keys of a virtual scan that say how surfaces and free space are found; all others are read already.
void read_cut(Mapping& yaml, const SensorConfig& source, const std::string& owner, Config& config,
              ConfigClaims& claims, VirtualScanConfig& scan);
const char* word_of(CutMode mode);
const char* word_of(GroundModel model);

}  // namespace lidard
