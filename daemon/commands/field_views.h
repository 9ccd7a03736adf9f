// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "daemon/commands/commands.h"
#include "daemon/files/snapshot_view.h"

namespace lidard {

/// One view for each merged and virtual scan of a configuration (of `areas` alone, if set): what it can know
/// of an empty field, between the sensors' fields of view and blind zones. Without such scans one of the
/// sensors. Throws std::runtime_error if there is no scan `areas`.
std::vector<SnapshotView> views_of_field(const SnapshotOptions& options, const Config& config);

}  // namespace lidard
