// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "drivers/velodyne/azimuth.h"
#include "drivers/velodyne/model_row.h"

namespace lidard::velodyne {

/// What the packet after one tells about it.
struct NextPacket {
  Span step;  ///< from stamp to stamp
};

/// When each group of a packet's blocks fired, and how fast the sensor turned meanwhile.
struct FiringSchedule {
  std::array<Span, blocks_per_packet> begin{};  ///< first firing of each group after the packet's stamp
  Span sequence{0};                             ///< from one firing sequence to the next
  Span end{0};                                  ///< of the packet's last sequence after the stamp
  double rate_deg_per_s = 0;
};

/// The schedule of a packet, by the timing in force and, where sequences rest for a random time, by the
/// sequences that were measured. Needs the next packet where sequences rest for a random time or where a
/// hidden sector lies inside the packet: the groups after it fired late, by the time of the silence. Without
/// it, `turn_rate` (deg/s of whole revolutions, 0 unknown) places them; a packet's own azimuth steps are too
/// coarse for that.
FiringSchedule schedule_of(const ModelRow& row, const Timing& timing, Span measured_sequence,
                           const PacketAzimuths& azimuths, std::size_t echoes,
                           const std::optional<NextPacket>& next, double turn_rate);

}  // namespace lidard::velodyne
