// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"

namespace lidard {

/// The warnings of a configuration without mistakes, and what is possible in it and hardly meant. Each
/// sentence begins with `file:line:column`.
std::vector<std::string> remarks_on(const Config& config);
/// The same of this host's network, for what talks to sensors.
std::vector<std::string> host_remarks_on(const Config& config);

}  // namespace lidard
