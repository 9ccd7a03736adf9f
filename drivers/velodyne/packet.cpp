// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/packet.h"

#include <algorithm>

namespace lidard::velodyne {
namespace {

constexpr std::uint8_t byte(std::size_t n) { return static_cast<std::uint8_t>(n); }

/// Single return: the banks of a sequence in order.
PacketLayout single(std::size_t banks) {
  PacketLayout layout;
  layout.banks = banks;
  layout.groups = blocks_per_packet / banks;
  for (std::size_t b = 0; b < blocks_per_packet; ++b) layout.block[b / banks][0][b % banks] = byte(b);
  return layout;
}

/// Dual return of sensors with one bank, and of the VLS-128: both returns of a bank side by side. A VLS-128
/// packet holds one sequence; the last four blocks are empty.
PacketLayout dual_by_bank(std::size_t banks) {
  PacketLayout layout;
  layout.banks = banks;
  layout.echoes = 2;
  layout.groups = blocks_per_packet / (2 * banks);
  for (std::size_t b = 0; b < layout.groups * 2 * banks; ++b) {
    layout.block[b / (2 * banks)][b % 2][b / 2 % banks] = byte(b);
  }
  return layout;
}

/// HDL-64E: both banks of one return, then both of the other.
PacketLayout dual_by_return() {
  PacketLayout layout;
  layout.banks = 2;
  layout.echoes = 2;
  layout.groups = 3;
  for (std::size_t b = 0; b < blocks_per_packet; ++b) layout.block[b / 4][b / 2 % 2][b % 2] = byte(b);
  return layout;
}

/// HDL-64E S1: every block is a sequence.
PacketLayout bank_by_bank() {
  PacketLayout layout = single(1);
  layout.banks = 2;
  layout.one_bank = true;
  for (auto& group : layout.block) group[0][1] = group[0][0];
  return layout;
}

/// HDL-64E S1: the lower lasers fire once for three times of the upper ones and have one block of four. All
/// 306 recorded packets (chalmers-revere/opendlv.core, "atwall") begin with it; other positions are accepted
/// too.
Reject check_single_banks(const DataPacket& packet) {
  std::size_t lower = 0;
  for (std::size_t b = 0; b < blocks_per_packet; ++b) {
    const std::uint16_t flag = packet.flag(b);
    if (flag != bank_flags[0] && flag != bank_flags[1]) return Reject::magic;
    if (b >= 4 && flag != packet.flag(b - 4)) return Reject::magic;
    lower += flag == bank_flags[1] ? 1U : 0U;
    if (packet.azimuth(b) >= whole_turn) return Reject::field;
  }
  return lower == blocks_per_packet / 4 ? Reject::none : Reject::magic;
}

/// VLS-128 modes 0x3A and 0x3B: return 1, return 2, confidence words of each bank. The words are not used.
PacketLayout dual_with_confidence() {
  PacketLayout layout;
  layout.banks = 4;
  layout.echoes = 2;
  layout.groups = 1;
  for (std::size_t b = 0; b < blocks_per_packet; ++b)
    if (b % 3 < 2) layout.block[0][b % 3][b / 3] = byte(b);
  return layout;
}

bool is_dual_hdl64e(const DataPacket& packet) {
  bool pairs_equal = true;
  bool all_equal = true;
  for (std::size_t b = 0; b < blocks_per_packet; b += 4) {
    pairs_equal = pairs_equal && packet.azimuth(b) == packet.azimuth(b + 2);
    all_equal = all_equal && packet.azimuth(b) == packet.azimuth(0);
  }
  // No mode byte: a standing motor looks like single return.
  return pairs_equal && !all_equal;
}

const PacketLayout single1 = single(1), single2 = single(2), single4 = single(4);
const PacketLayout dual1 = dual_by_bank(1), dual4 = dual_by_bank(4), dual2 = dual_by_return();
const PacketLayout confident = dual_with_confidence(), alternating = bank_by_bank();

}  // namespace

const PacketLayout& layout_of(const DataPacket& packet, const ModelRow& row) {
  if (row.bank_by_bank) return alternating;
  if (row.banks == 1) return is_dual(packet) ? dual1 : single1;
  if (row.banks == 2) return is_dual_hdl64e(packet) ? dual2 : single2;
  constexpr std::uint8_t triple = 0x3A, confidence = 0x3B;  // VeloView vtkDataPacket.h; 0x3A unverified
  if (packet.mode() == triple || packet.mode() == confidence) return confident;
  return packet.flag(0) == packet.flag(1) ? dual4 : single4;
}

Reject check_blocks(const DataPacket& packet, const PacketLayout& layout) {
  if (layout.one_bank) return check_single_banks(packet);
  for (std::size_t g = 0; g < layout.groups; ++g) {
    for (std::size_t e = 0; e < layout.echoes; ++e) {
      for (std::size_t bank = 0; bank < layout.banks; ++bank) {
        const std::size_t b = layout.block[g][e][bank];
        if (packet.flag(b) != bank_flags[bank]) return Reject::magic;
        if (packet.azimuth(b) >= whole_turn) return Reject::field;
      }
    }
  }
  return Reject::none;
}

namespace {

constexpr double gap_factor = 4;
constexpr int smallest_gap = 100;     // 1/100 deg
constexpr int backwards_limit = 100;  // 1/100 deg

int step_between(int from, int to) {
  const int step = to >= from ? to - from : to - from + whole_turn;
  return step > whole_turn - backwards_limit ? step - whole_turn : step;
}

}  // namespace

double plausible_rate(double deg_per_s) {
  constexpr double slowest = 36, fastest = 14400;
  return deg_per_s >= slowest && deg_per_s <= fastest ? deg_per_s : 0;
}

PacketAzimuths read_azimuths(const DataPacket& packet, const PacketLayout& layout) {
  PacketAzimuths azimuths;
  azimuths.groups = layout.groups;
  std::array<int, blocks_per_packet> steps{};
  const std::size_t count = azimuths.groups - 1;
  int last = packet.azimuth(layout.first_block(0));
  int sum = 0;
  int largest = 0;
  azimuths.group[0] = last;
  for (std::size_t g = 1; g < azimuths.groups; ++g) {
    const int azimuth = packet.azimuth(layout.first_block(g));
    azimuths.group[g] = azimuth;
    const int step = step_between(last, azimuth);
    steps[g - 1] = step;
    sum += step;
    largest = std::max(largest, step);
    last = azimuth;
  }
  if (count == 0) return azimuths;
  if (largest <= smallest_gap) {
    azimuths.step_deg = 0.01 * sum / static_cast<int>(count);
    return azimuths;
  }
  auto sorted = steps;
  // The lower median, so that a hidden sector among few steps does not count.
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((count - 1) / 2);
  std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(count));
  const int median = *middle;
  const double limit = std::max(gap_factor * median, static_cast<double>(smallest_gap));
  int used = 0;
  sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (steps[i] > limit) {
      azimuths.hidden_deg[i + 1] = 0.01 * (steps[i] - median);
      azimuths.hidden_total_deg += azimuths.hidden_deg[i + 1];
      continue;
    }
    sum += steps[i];
    ++used;
  }
  azimuths.step_deg = used > 0 ? 0.01 * sum / used : 0;
  return azimuths;
}

}  // namespace lidard::velodyne
