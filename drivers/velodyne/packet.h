// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "core/base/bytes.h"
#include "core/base/counters.h"
#include "core/base/time.h"
#include "drivers/velodyne/models.h"

namespace lidard::velodyne {

// Layout of the data packet, common to all spinning models: VLP-16 user manual 63-9243 Rev D, section 9.3.
constexpr std::size_t packet_size = 1206;
constexpr std::size_t blocks_per_packet = 12;
constexpr std::size_t slots_per_block = 32;
constexpr std::size_t block_size = 100;
constexpr std::size_t stamp_offset = 1200;
constexpr std::size_t mode_offset = 1204;
constexpr std::size_t product_offset = 1205;
constexpr std::uint16_t flag_lasers_0_31 = 0xEEFF;
constexpr std::uint16_t whole_turn = 36000;  // 1/100 deg
/// 63-9243 Rev D, section 9.3.1.6: the position packet.
constexpr std::size_t position_packet_size = 512;

/// Return-mode byte, 63-9243 Rev D, table 9-2.
enum class ReturnMode : std::uint8_t { strongest = 0x37, last = 0x38, dual = 0x39 };

/// A data packet of the right size.
class DataPacket {
 public:
  explicit DataPacket(ByteView bytes) : bytes_(bytes) {}

  std::uint16_t flag(std::size_t block) const { return bytes_.le16(block * block_size); }
  /// 1/100 deg. Exactly a full turn means 0; it was reported for a VLP-16 and an HDL-32E, once in about 2,000
  /// packets, and does not occur in the captures of test/CAPTURES.md. More than a turn stays unchanged.
  std::uint16_t azimuth(std::size_t block) const {
    const std::uint16_t sent = bytes_.le16(block * block_size + 2);
    return sent == whole_turn ? std::uint16_t{0} : sent;
  }
  /// 32 slots of 3 bytes: distance count (u16 LE, 0 = no return), reflectivity.
  const std::uint8_t* slots(std::size_t block) const { return bytes_.data() + block * block_size + 4; }
  std::uint32_t stamp_us() const { return bytes_.le32(stamp_offset); }
  std::uint8_t mode() const { return bytes_.u8(mode_offset); }
  std::uint8_t product() const { return bytes_.u8(product_offset); }

 private:
  ByteView bytes_;
};

/// True if the blocks of every pair have one azimuth while the pairs differ, as only in dual return. If the
/// motor stands, all azimuths are equal, and the mode byte decides.
inline bool is_dual(const DataPacket& packet) {
  bool pairs_equal = true;
  bool all_equal = true;
  for (std::size_t b = 0; b < blocks_per_packet; b += 2) {
    pairs_equal = pairs_equal && packet.azimuth(b) == packet.azimuth(b + 1);
    all_equal = all_equal && packet.azimuth(b) == packet.azimuth(0);
  }
  if (pairs_equal && all_equal) return packet.mode() == static_cast<std::uint8_t>(ReturnMode::dual);
  return pairs_equal;
}

/// Which block holds which part of which firing sequence, for one model and return mode
/// (63-9243 Rev D, section 9.3; UniBwTAS/velodyne and VeloView for the VLS-128).
struct PacketLayout {
  std::size_t groups = 0;  ///< sets of blocks with one azimuth
  std::size_t echoes = 1;
  std::size_t banks = 1;
  bool one_bank = false;  ///< a block has the lasers of one bank, given by its flag; the other bank is silent
  std::array<std::array<std::array<std::uint8_t, 4>, 2>, 12> block{};  ///< [group][echo][bank]

  std::size_t first_block(std::size_t group) const { return block[group][0][0]; }
};

/// The layout of the packet, from azimuths and flags, or from the mode byte if the motor stands.
const PacketLayout& layout_of(const DataPacket& packet, const ModelRow& row);

/// The flags of the blocks of each bank.
inline constexpr std::array<std::uint16_t, 4> bank_flags{flag_lasers_0_31, 0xDDFF, 0xCCFF, 0xBBFF};
/// Slots of a bank that did not fire. The kernels read eight bytes more than the slots.
inline constexpr std::array<std::uint8_t, 3 * slots_per_block + 8> silent_slots{};

/// The first slot of a bank in a group and return; silent_slots if the bank did not fire.
inline const std::uint8_t* slots_of(const DataPacket& packet, const PacketLayout& layout, std::size_t group,
                                    std::size_t echo, std::size_t bank) {
  const std::size_t b = layout.block[group][echo][bank];
  return layout.one_bank && packet.flag(b) != bank_flags[bank] ? silent_slots.data() : packet.slots(b);
}

/// Checks the flags and azimuths of all blocks of the layout.
Reject check_blocks(const DataPacket& packet, const PacketLayout& layout);

/// An angle in the unit of the wire, 1/100 deg. Sums and differences are exact.
using Hundredths = std::int32_t;

/// The azimuths of a packet's groups of blocks.
struct PacketAzimuths {
  std::array<Hundredths, blocks_per_packet> group{};  ///< below a whole turn
  std::array<double, blocks_per_packet>
      hidden_deg{};  ///< hidden sector between the group before and this one; 0 none
  std::size_t groups = 0;
  double step_deg = 0;          ///< mean step from group to group, without hidden sectors
  double hidden_total_deg = 0;  ///< sum of hidden_deg

  double group_deg(std::size_t g) const { return group[g] * 0.01; }
};

/// The rate of a rotation, deg/s, or 0 (unknown) if no motor turns like that: below 6 rpm, or above twice the
/// maximum of 1200 rpm.
double plausible_rate(double deg_per_s);

/// Reads the azimuths and the mean step, which is more precise than single steps of 0.01 deg. A step far
/// above the median crosses a hidden sector (the field of view ends inside the packet: measured on a
/// VLP-32C).
PacketAzimuths read_azimuths(const DataPacket& packet, const PacketLayout& layout);

/// Signed difference of two hour stamps, later - earlier, within half an hour. Correct also if the counter
/// passes 3600 s without a reset (ros-drivers/velodyne#218).
inline Span hour_difference(Span later, Span earlier) {
  constexpr Span hour = std::chrono::hours(1);
  const Span difference = (later - earlier) % hour;
  if (difference > hour / 2) return difference - hour;
  return difference <= -hour / 2 ? difference + hour : difference;
}
inline Span hour_difference(std::uint32_t later_us, std::uint32_t earlier_us) {
  return hour_difference(std::chrono::microseconds(later_us), std::chrono::microseconds(earlier_us));
}

}  // namespace lidard::velodyne
