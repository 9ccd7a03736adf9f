// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "core/cloud.h"
#include "core/scan.h"

namespace lidard::test {

/// Five beams from -1 to 1 rad: hit at 1 m, none, near, invalid, hit at 40 m; intensities 10 to 50.
PlanarScan sample_scan();
/// A cloud of 16 rings with `points` distinct points, 0.1 ms apart.
Cloud sample_cloud(std::size_t points);

}  // namespace lidard::test
