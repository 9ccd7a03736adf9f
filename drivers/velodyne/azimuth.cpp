// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/azimuth.h"

#include <algorithm>

namespace lidard::velodyne {
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
  // The lower median: with few steps a hidden sector must not become the measure.
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
