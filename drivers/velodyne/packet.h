// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/base/bytes.h"

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

/// A data packet whose size was checked.
class DataPacket {
 public:
  explicit DataPacket(ByteView bytes) : bytes_(bytes) {}

  std::uint16_t flag(std::size_t block) const { return bytes_.le16(block * block_size); }
  /// 1/100 deg. Exactly a whole turn means 0; it was reported of a VLP-16 and of an HDL-32E, once in about
  /// 2,000 packets, and stands in none of the captures of test/CAPTURES.md. More than a turn stays as it is.
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

/// True if each block pair shares one azimuth while the pairs differ: only dual return looks so. Where the
/// motor stands still all azimuths are equal, and the mode byte decides.
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

}  // namespace lidard::velodyne
