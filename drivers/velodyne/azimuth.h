// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "drivers/velodyne/packet_layout.h"

namespace lidard::velodyne {

/// An angle or a turn in the wire's unit, 1/100 deg. Sums and differences of it are exact.
using Hundredths = std::int32_t;

/// The azimuths of a packet's groups of blocks.
struct PacketAzimuths {
  std::array<Hundredths, blocks_per_packet> group{};  ///< below a whole turn
  std::array<double, blocks_per_packet>
      hidden_deg{};  ///< hidden sector between the group before and this one; 0 none
  std::size_t groups = 0;
  double step_deg = 0;          ///< mean step from group to group, hidden sectors left out
  double hidden_total_deg = 0;  ///< sum of hidden_deg

  double group_deg(std::size_t g) const { return group[g] * 0.01; }
};

/// The rate of a rotation, deg/s, or 0 (unknown) where no motor turns so: below 6 rpm, or above twice the
/// 1200 rpm that the manuals allow at most. It bounds what is computed of a rate that noise, or packets of
/// something else, made up.
double plausible_rate(double deg_per_s);

/// Reads the azimuths and the mean step, which interpolates better than any single step: the wire has only
/// 0.01 deg. A step far above the median crosses a sector that the sensor does not send (its field of view
/// ends inside the packet: measured on a VLP-32C).
PacketAzimuths read_azimuths(const DataPacket& packet, const PacketLayout& layout);

}  // namespace lidard::velodyne
