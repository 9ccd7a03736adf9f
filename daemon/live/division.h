// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/config/config.h"

namespace lidard {

/// A configuration divided among the threads of a running daemon. A replay has one thread and does without.
struct Division {
  explicit Division(Config config);

  const Config whole;
  Config planes;  ///< of the sensor thread: planar scanners and merged scans
  /// Of the thread for clouds: multi-plane lidars, merged clouds and virtual scans. A planar scanner that is
  /// a source of a merged cloud, or shares a UDP port with a multi-plane lidar, goes with them.
  Config clouds;
};

}  // namespace lidard
