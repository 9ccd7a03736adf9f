// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>

#include "drivers/velodyne/packet_layout.h"

namespace lidard::velodyne {

/// The azimuths of a packet's groups of blocks.
struct PacketAzimuths {
  std::array<double, blocks_per_packet> group_deg{};
  std::array<double, blocks_per_packet>
      hidden_deg{};  ///< hidden sector between the group before and this one; 0 none
  std::size_t groups = 0;
  double step_deg = 0;          ///< mean step from group to group, hidden sectors left out
  double hidden_total_deg = 0;  ///< sum of hidden_deg
};

/// Reads the azimuths and the mean step, which interpolates better than any single step: the wire has only
/// 0.01 deg. A step far above the median crosses a sector that the sensor does not send (its field of view
/// ends inside the packet: measured on a VLP-32C).
PacketAzimuths read_azimuths(const DataPacket& packet, const PacketLayout& layout);

}  // namespace lidard::velodyne
