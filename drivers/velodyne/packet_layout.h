// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "core/base/counters.h"
#include "drivers/velodyne/model_row.h"
#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {

/// Which block holds which part of which firing sequence, for one model and return mode
/// (63-9243 Rev D, section 9.3; UniBwTAS/velodyne and VeloView for the VLS-128).
struct PacketLayout {
  std::size_t groups = 0;  ///< sets of blocks with one azimuth
  std::size_t echoes = 1;
  bool confidence = false;  ///< a third block of each bank holds confidence words
  std::size_t banks = 1;
  bool one_bank =
      false;  ///< each block has the lasers of one bank, which its flag names; the other is silent
  std::array<std::array<std::array<std::uint8_t, 4>, 3>, 12>
      block{};  ///< [group][echo or 2 = confidence][bank]

  std::size_t first_block(std::size_t group) const { return block[group][0][0]; }
};

/// How the packet is laid out. Dual return shows in the azimuths and flags; where the motor stands still all
/// azimuths are equal, and the mode byte decides.
const PacketLayout& layout_of(const DataPacket& packet, const ModelRow& row);

/// The flags of the blocks of each bank.
inline constexpr std::array<std::uint16_t, 4> bank_flags{flag_lasers_0_31, 0xDDFF, 0xCCFF, 0xBBFF};
/// Of a bank that did not fire. The kernels read eight bytes more than the slots.
inline constexpr std::array<std::uint8_t, 3 * slots_per_block + 8> silent_slots{};

/// The first slot of a bank in that group and return; of a bank that is silent there, slots without returns.
inline const std::uint8_t* slots_of(const DataPacket& packet, const PacketLayout& layout, std::size_t group,
                                    std::size_t echo, std::size_t bank) {
  const std::size_t b = layout.block[group][echo][bank];
  return layout.one_bank && packet.flag(b) != bank_flags[bank] ? silent_slots.data() : packet.slots(b);
}

/// Flags and azimuths of every block the layout uses.
Reject check_blocks(const DataPacket& packet, const PacketLayout& layout);

}  // namespace lidard::velodyne
