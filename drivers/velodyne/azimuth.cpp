// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/azimuth.h"

#include <algorithm>

namespace lidard::velodyne {
namespace {

constexpr double gap_factor =
    4;  // a step this much larger than the median crosses a sector the sensor does not send
constexpr int backwards_limit = 100;  // 1/100 deg

int step_between(int from, int to) {
  const int step = (to - from + azimuth_limit) % azimuth_limit;
  return step > azimuth_limit - backwards_limit ? step - azimuth_limit : step;
}

}  // namespace

PacketAzimuths read_azimuths(const DataPacket& packet, std::size_t blocks_per_group) {
  PacketAzimuths azimuths;
  azimuths.groups = blocks_per_packet / blocks_per_group;
  std::array<int, blocks_per_packet> steps{};
  const std::size_t count = azimuths.groups - 1;
  for (std::size_t g = 0; g < azimuths.groups; ++g) {
    const int azimuth = packet.azimuth(g * blocks_per_group);
    azimuths.group_deg[g] = azimuth * 0.01;
    if (g > 0) steps[g - 1] = step_between(packet.azimuth((g - 1) * blocks_per_group), azimuth);
  }
  auto sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(count));
  const double limit = std::max(gap_factor * *middle, 1.0);
  int sum = 0;
  int used = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (steps[i] > limit) continue;
    sum += steps[i];
    ++used;
  }
  azimuths.step_deg = used > 0 ? 0.01 * sum / used : 0;
  return azimuths;
}

}  // namespace lidard::velodyne
