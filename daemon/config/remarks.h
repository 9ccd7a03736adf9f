// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/config/config.h"
#include "drivers/document.h"

namespace lidard {

/// Adds warnings to a configuration without mistakes: what is possible, and hardly meant. `root`: its file.
void add_remarks(const Value& root, Config& config);

}  // namespace lidard
