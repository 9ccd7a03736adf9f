// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/hidden_sectors.h"

#include <algorithm>
#include <cmath>

namespace lidard::velodyne {
namespace {

/// A narrower hole between packets is always loss: fields of view hide more.
constexpr double smallest_candidate_deg = 10;
constexpr double smallest_sector_deg = 1;
/// An edge may move by so much from turn to turn, for the steps of the groups fall elsewhere.
constexpr double same_edge_deg = 1;
/// Half the wire's step, for both ends of an interpolation.
constexpr double tolerance_deg = 0.01;
constexpr int passes_for_certainty = 3;
/// Chance is ruled out where it would do such a thing once in so many streams.
const double log_certainty = std::log(1e3);

/// From `a` clockwise to `b`, all in [0, 360).
double ahead(double a, double b) {
  const double d = b - a;
  return d < 0 ? d + 360 : d;
}

double wrapped(double a) { return a < 360 ? a : a - 360; }

bool is_near(double a, double b) { return std::fabs(std::remainder(a - b, 360)) < same_edge_deg; }

std::int64_t lost_of(const StreamHole& hole, std::int64_t hidden) {
  const double packets = static_cast<double>(hole.groups - hidden) / static_cast<double>(hole.per_packet);
  return std::max<std::int64_t>(0, std::llround(packets) - 1);
}

/// Groups of the hole, the first of them numbered 0, between two angles after that one.
std::int64_t groups_between(const StreamHole& hole, double begin_deg, double end_deg) {
  const double step = hole.turned_deg / static_cast<double>(hole.groups);
  const auto first = static_cast<std::int64_t>(std::floor((begin_deg + tolerance_deg) / step)) + 1;
  const auto last = static_cast<std::int64_t>(std::ceil((end_deg - tolerance_deg) / step)) - 1;
  return std::max<std::int64_t>(0, std::min(last, hole.groups - 1) - std::max<std::int64_t>(first, 0) + 1);
}

}  // namespace

std::int64_t HiddenSectors::hidden_groups(const StreamHole& hole) const {
  std::int64_t hidden = 0;
  if (hole.turned_deg <= 0) return 0;
  for (const Sector& s : sectors_) {
    if (!s.used) continue;
    for (double begin = ahead(hole.from_deg, s.from_deg) - 360; begin < hole.turned_deg; begin += 360)
      hidden += groups_between(hole, begin, begin + s.width_deg);
  }
  return hidden;
}

/// Counts the holes of the past with what is known now.
std::uint64_t HiddenSectors::count_again() {
  std::uint64_t more = 0;
  for (Past& past : past_) {
    if (!past.used) continue;
    const std::int64_t lost = lost_of(past.hole, hidden_groups(past.hole));
    if (lost <= past.counted) continue;
    more += static_cast<std::uint64_t>(lost - past.counted);
    past.counted = lost;
  }
  lost_ += more;
  return more;
}

bool HiddenSectors::could_be_chance(const Sector& sector) const {
  const double all = static_cast<double>(received_ + lost_ + 1);
  // Also a stream without any loss so far may begin to lose packets.
  const double share = std::max(static_cast<double>(lost_) / all, 1e-3);
  const double packets = sector.passes * sector.width_deg / sector.packet_deg;
  return packets * -std::log(share) < std::log(all) + log_certainty;
}

std::uint64_t HiddenSectors::hole(const StreamHole& hole) {
  if (hole.turned_deg > 0 && hole.turned_deg < 360) {
    add_candidates(hole);
    for (Sector& s : sectors_) {
      if (!s.used || ahead(hole.from_deg, s.from_deg) + s.width_deg > hole.turned_deg + same_edge_deg)
        continue;
      ++s.passes;
      if (s.known || s.passes < passes_for_certainty || could_be_chance(s)) continue;
      s.known = true;
      s.slack_deg = 2 * s.packet_deg + same_edge_deg;
    }
  }
  const std::int64_t hidden = hidden_groups(hole);
  const std::int64_t lost = lost_of(hole, hidden);
  if (hidden > 0) {
    past_[next_past_] = {hole, lost, true};
    next_past_ = (next_past_ + 1) % past_.size();
  }
  lost_ += static_cast<std::uint64_t>(lost);
  return static_cast<std::uint64_t>(lost);
}

/// What no sector explains of the hole may be another one.
void HiddenSectors::add_candidates(const StreamHole& hole) {
  const double packet_deg =
      hole.turned_deg * static_cast<double>(hole.per_packet) / static_cast<double>(hole.groups);
  double begin = hole.last_deg;
  double left = hole.turned_deg - ahead(hole.from_deg, hole.last_deg);
  while (left >= smallest_candidate_deg) {
    // The nearest sector that begins, or has begun, ahead.
    const Sector* next = nullptr;
    double to_next = left;
    for (const Sector& s : sectors_) {
      if (!s.used) continue;
      const bool within = ahead(s.from_deg, begin) < s.width_deg;
      const double distance = within ? 0 : ahead(begin, s.from_deg);
      if (distance < to_next || (within && next == nullptr)) next = &s, to_next = distance;
    }
    if (to_next >= smallest_candidate_deg) add_sector(begin, to_next, packet_deg);
    if (next == nullptr) return;
    const double skipped = ahead(begin, wrapped(next->from_deg + next->width_deg));
    begin = wrapped(next->from_deg + next->width_deg);
    left -= skipped;
  }
}

void HiddenSectors::add_sector(double from_deg, double width_deg, double packet_deg) {
  for (Sector& s : sectors_) {
    if (s.used) continue;
    s = Sector{};
    s.from_deg = from_deg;
    s.width_deg = width_deg;
    s.packet_deg = packet_deg;
    s.used = true;
    return;
  }
}

/// A packet had this sector inside it. True if that is news.
bool HiddenSectors::learn(double from_deg, double to_deg, double packet_deg) {
  const double width = ahead(from_deg, to_deg);
  Sector* place = nullptr;
  for (Sector& s : sectors_) {
    if (s.used && is_near(s.from_deg, from_deg) && is_near(s.from_deg + s.width_deg, to_deg)) {
      // The narrower one of both is right: nothing ever came from within it.
      if (!s.known) s.slack_deg = same_edge_deg;
      s.known = true;
      return false;
    }
    const bool overlaps = ahead(from_deg, s.from_deg) < width || ahead(s.from_deg, from_deg) < s.width_deg;
    if (overlaps) s.used = false;
    if (!s.used) place = &s;
  }
  if (place == nullptr) place = &sectors_[0];
  *place = {from_deg, width, packet_deg, same_edge_deg, 0, true, true};
  return true;
}

/// Something came from within the sector: only what lies beside it can be hidden.
void HiddenSectors::take_out(Sector& sector, double azimuth_deg) {
  const double before = ahead(sector.from_deg, azimuth_deg);
  const double after = sector.width_deg - before;
  const double smallest = sector.known ? smallest_sector_deg : smallest_candidate_deg;
  sector.slack_deg -= std::min(before, after);
  if (sector.known && sector.slack_deg < 0) {
    // More than its edge: the field of view was changed, and the holes of the past were right.
    sector.used = false;
    past_ = {};
    return;
  }
  const Sector whole = sector;
  if (before < after) sector.from_deg = azimuth_deg;
  sector.width_deg = std::max(before, after);
  sector.used = sector.width_deg >= smallest;
  if (whole.known || std::min(before, after) < smallest) return;
  add_sector(before < after ? whole.from_deg : azimuth_deg, std::min(before, after), whole.packet_deg);
}

std::uint64_t HiddenSectors::receive(const PacketAzimuths& azimuths) {
  ++received_;
  bool moved = false;
  for (Sector& s : sectors_) {
    for (std::size_t g = 0; s.used && g < azimuths.groups; ++g) {
      const double inside = ahead(s.from_deg, azimuths.group_deg[g]);
      if (inside < 1e-6 || inside > s.width_deg - 1e-6) continue;
      moved = true;
      take_out(s, azimuths.group_deg[g]);
    }
  }
  const double packet_deg = azimuths.step_deg * static_cast<double>(azimuths.groups);
  for (std::size_t g = 1; g < azimuths.groups && azimuths.hidden_total_deg > 0; ++g) {
    if (azimuths.hidden_deg[g] > 0) learn(azimuths.group_deg[g - 1], azimuths.group_deg[g], packet_deg);
  }
  return moved ? count_again() : 0;
}

std::uint64_t HiddenSectors::finish() {
  for (Sector& s : sectors_) {
    if (s.used && !s.known && could_be_chance(s)) s.used = false;
  }
  const std::uint64_t lost = count_again();
  reset();
  return lost;
}

std::optional<double> HiddenSectors::middle_deg() const {
  const Sector* widest = nullptr;
  for (const Sector& s : sectors_) {
    if (s.used && s.known && (widest == nullptr || s.width_deg > widest->width_deg)) widest = &s;
  }
  if (widest == nullptr) return std::nullopt;
  return wrapped(widest->from_deg + widest->width_deg / 2);
}

}  // namespace lidard::velodyne
