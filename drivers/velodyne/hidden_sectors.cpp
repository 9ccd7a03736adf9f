// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/hidden_sectors.h"

#include <cmath>

namespace lidard::velodyne {
namespace {

/// A smaller hole is always loss: fields of view hide more, and one lost packet of a VLP-16 leaves 5 deg.
constexpr double smallest_sector_deg = 20;
/// Block azimuths at the edge of the field of view move by the step from block to block.
constexpr double same_place_deg = 1.0;
constexpr int turns_for_certainty = 3;
constexpr double longest_wait_deg = 400;

bool near(double a, double b) {
  const double d = std::fabs(std::fmod(a - b + 540, 360) - 180);
  return d < same_place_deg;
}

}  // namespace

HiddenSectors::Sector* HiddenSectors::find(double from_deg, double to_deg) {
  for (Sector& s : sectors_) {
    if (s.used && near(s.from_deg, from_deg) && near(s.to_deg, to_deg)) return &s;
  }
  return nullptr;
}

void HiddenSectors::learn(double from_deg, double to_deg) {
  Sector* sector = find(from_deg, to_deg);
  for (Sector& s : sectors_) {
    if (sector == nullptr && !s.used) sector = &s;
  }
  if (sector == nullptr) sector = &sectors_[0];
  sector->used = sector->known = true;
  sector->from_deg = from_deg;
  sector->to_deg = to_deg;
  sector->packets = 0;
}

std::uint64_t HiddenSectors::hole(double from_deg, double to_deg, std::uint64_t packets, double turned_deg) {
  std::uint64_t lost = 0;
  for (Sector& s : sectors_) {
    if (!s.used || s.known || turned_deg - s.last_turned_deg < longest_wait_deg) continue;
    lost += s.packets;
    s = Sector{};
  }
  if (std::fmod(to_deg - from_deg + 360, 360) < smallest_sector_deg) return lost + packets;
  Sector* sector = find(from_deg, to_deg);
  if (sector != nullptr && sector->known) return lost;
  for (Sector& s : sectors_) {
    if (sector == nullptr && !s.used) sector = &s;
  }
  if (sector == nullptr) return lost + packets;
  sector->used = true;
  sector->from_deg = from_deg;
  sector->to_deg = to_deg;
  sector->packets += packets;
  sector->last_turned_deg = turned_deg;
  if (++sector->turns >= turns_for_certainty) {
    sector->known = true;
    sector->packets = 0;
  }
  return lost;
}

std::uint64_t HiddenSectors::finish() {
  std::uint64_t lost = 0;
  for (Sector& s : sectors_) {
    if (s.used && !s.known && s.turns < 2) lost += s.packets;
    s = Sector{};
  }
  return lost;
}

}  // namespace lidard::velodyne
