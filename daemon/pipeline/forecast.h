// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"

namespace lidard {

/// What can be known of the outputs of a configuration without data: which poses only tf can tell, and which
/// sources only another node can give. `text` is what `config` was read from; each sentence begins with
/// `file:line:column`.
std::vector<std::string> forecast(const Config& config, const std::string& text);

}  // namespace lidard
