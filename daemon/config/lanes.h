// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "daemon/config/config.h"

namespace lidard {

/// The two ways through a running daemon, each with threads of its own, so that planar scanners and what is
/// merged of them never wait for clouds. A replay has one way, where everything comes in one order.
enum class Lane : std::uint8_t {
  planes,  ///< planar scanners and all merged scans
  clouds   ///< multi-plane lidars, merged clouds with all of their sources, and virtual scans
};

/// The part of a configuration that belongs to one lane. What is merged of the lane of clouds is named in
/// `hand_over` there, and in the same order in `handed_over` of the lane of planes. A planar scanner that
/// shares a UDP port with a multi-plane lidar goes with it.
Config part_of(const Config& config, Lane lane);

}  // namespace lidard
