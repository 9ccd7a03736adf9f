// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "core/frames/cloud.h"
#include "core/frames/gnss.h"
#include "core/frames/imu.h"
#include "core/frames/scan.h"

namespace lidard::test {

/// Five beams from -1 to 1 rad: hit at 1 m, none, near, invalid, hit at 40 m; intensities 10 to 50.
PlanarScan sample_scan();
/// A cloud of 16 rings with `points` distinct points, 0.1 ms apart.
Cloud sample_cloud(std::size_t points);
/// A fix with corrections, of known altitude.
GnssFix sample_fix();
/// An instant that both clocks tell, from "gps_pps".
TimeReference sample_time_reference();
/// Turning left on level ground.
ImuSample sample_imu();

}  // namespace lidard::test
