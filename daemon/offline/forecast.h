// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/offline/field_sight.h"

namespace lidard {

/// What a configuration shows without data: poses that come only from tf, sources of other nodes, and outputs
/// that can never come. `sights`: what its outputs can know. Each sentence begins with
/// `file:line:column`.
std::vector<std::string> forecast(const Config& config, const std::vector<FieldSight>& sights);

}  // namespace lidard
