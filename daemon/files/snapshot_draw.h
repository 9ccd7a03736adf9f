// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "daemon/files/snapshot_chart.h"
#include "daemon/files/snapshot_view.h"

namespace lidard {

/// Pixels of the picture's side.
constexpr double snapshot_side = 1200;

/// The picture as the bytes of a PNG or SVG file.
std::string draw_snapshot(const SnapshotView& view, Chart::Format format);

}  // namespace lidard
