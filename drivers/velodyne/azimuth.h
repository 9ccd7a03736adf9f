// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {

/// The azimuths of a packet's groups of blocks: one block in single return mode, a pair in dual.
struct PacketAzimuths {
  std::array<double, blocks_per_packet> group_deg{};
  std::size_t groups = 0;
  double step_deg = 0;  ///< mean step from group to group, without steps across a hidden sector
};

/// Reads the azimuths and the mean step, which interpolates better than any single step: the wire has only
/// 0.01 deg.
PacketAzimuths read_azimuths(const DataPacket& packet, std::size_t blocks_per_group);

}  // namespace lidard::velodyne
