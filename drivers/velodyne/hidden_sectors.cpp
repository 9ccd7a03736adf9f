// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/hidden_sectors.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace lidard::velodyne {
namespace {

/// A narrower hole between packets is always loss.
constexpr Hundredths smallest_candidate = 1000;
constexpr Hundredths smallest_sector = 100;
/// An edge may move by this from turn to turn with the steps of the groups.
constexpr Hundredths same_edge = 100;
/// Half the step on the wire, for both ends of an interpolation.
constexpr Hundredths tolerance = 1;
/// Number of holes in one place that make a sector; more are required if the stream has bursts of loss or if
/// groups were received there.
constexpr std::int64_t passes_for_certainty = 3;
constexpr std::int64_t passes_against_bursts = 10;
/// Chance is excluded if it explains the holes in fewer than one of 1000 streams.
const double log_certainty = std::log(1e3);

/// From `a` clockwise to `b`, all in [0, whole_turn).
Hundredths ahead(Hundredths a, Hundredths b) {
  const Hundredths d = b - a;
  return d < 0 ? d + whole_turn : d;
}

bool is_near(Hundredths a, Hundredths b) {
  const Hundredths d = ahead(a, b);
  return std::min(d, whole_turn - d) < same_edge;
}

bool is_inside(Hundredths azimuth, Hundredths from, Hundredths width) {
  const Hundredths after = ahead(from, azimuth);
  return after > 0 && after < width;
}

std::int64_t lost_of(const StreamHole& hole, std::int64_t hidden) {
  const double packets = static_cast<double>(hole.groups - hidden) / static_cast<double>(hole.per_packet);
  return std::max<std::int64_t>(0, std::llround(packets) - 1);
}

/// The sum of floor((a * i + b) / m) over i in [0, n); nothing is negative, and n and m are positive.
std::int64_t sum_of_floors(std::int64_t n, std::int64_t m, std::int64_t a, std::int64_t b) {
  std::int64_t sum = 0;
  // Euclid's algorithm on a and m: the smaller one at least halves in two rounds.
  while (true) {
    sum += n * (n - 1) / 2 * (a / m) + n * (b / m);
    a %= m;
    b %= m;
    const std::int64_t top = a * n + b;
    if (top < m) return sum;
    n = top / m;
    b = top % m;
    std::swap(a, m);
  }
}

/// Groups of the hole inside a sector, in all its turns. Group g is at g * turned / groups after the hole's
/// begin. It is inside if it has passed more begins than ends of the sector; integers avoid rounding. A hole
/// lasts some seconds at most, so all products fit into 64 bits.
std::int64_t groups_inside(const StreamHole& hole, Hundredths from, Hundredths width) {
  if (width <= 2 * tolerance) return 0;
  const std::int64_t turn = whole_turn * hole.groups;
  const std::int64_t begin = (ahead(hole.from, from) + tolerance) * hole.groups;
  const std::int64_t end = begin + (width - 2 * tolerance) * hole.groups;
  // A begin must lie before the group, an end may coincide with it.
  const std::int64_t begins = sum_of_floors(hole.groups, turn, hole.turned, 2 * turn - 1 - begin);
  const std::int64_t ends = sum_of_floors(hole.groups, turn, hole.turned, 2 * turn - end);
  return begins - ends;
}

}  // namespace

std::int64_t HiddenSectors::hidden_groups(const StreamHole& hole) const {
  std::int64_t hidden = 0;
  if (hole.turned <= 0) return 0;
  for (const Sector& s : sectors_) {
    if (s.used) hidden += groups_inside(hole, s.from, s.width);
  }
  return hidden;
}

/// Recounts the past holes with the current sectors.
void HiddenSectors::count_again() {
  for (Past& past : past_) {
    if (!past.used) continue;
    const std::int64_t hidden = hidden_groups(past.hole);
    const std::int64_t lost = lost_of(past.hole, hidden);
    past.used = hidden > 0;
    bursts_ = bursts_ || hidden == 0;
    if (lost <= past.counted) continue;
    lost_ += static_cast<std::uint64_t>(lost - past.counted);
    past.counted = lost;
  }
}

bool HiddenSectors::could_be_chance(const Sector& sector) const {
  const double all = static_cast<double>(received_ + lost_ + 1);
  // A stream without loss so far may still lose packets.
  const double share = std::max(static_cast<double>(lost_) / all, 1e-3);
  const double packets = static_cast<double>(sector.passes) * sector.width / sector.packet;
  return packets * -std::log(share) < std::log(all) + log_certainty;
}

/// True if a group of a full degree inside the sector was received.
bool HiddenSectors::was_seen(const Sector& sector) const {
  const Hundredths first = sector.from / 100 + 1;  // both edges were received
  const Hundredths last = (sector.from + sector.width) / 100;
  for (Hundredths degree = first; degree < last; ++degree) {
    if (seen_[static_cast<std::size_t>(degree % 360)]) return true;
  }
  return false;
}

/// Counts a hole over the full sector.
void HiddenSectors::pass(Sector& sector) {
  ++sector.passes;
  if (sector.known || sector.passes < passes_for_certainty) return;
  if (sector.passes < passes_against_bursts && (bursts_ || was_seen(sector))) return;
  if (could_be_chance(sector)) return;
  sector.known = true;
  sector.slack = 2 * sector.packet + same_edge;
}

std::uint64_t HiddenSectors::hole(const StreamHole& hole) {
  if (hole.turned > 0 && hole.turned < whole_turn) {
    add_candidates(hole);
    for (Sector& s : sectors_) {
      if (s.used && ahead(hole.from, s.from) + s.width <= hole.turned + same_edge) pass(s);
    }
  }
  const std::int64_t hidden = hidden_groups(hole);
  const std::int64_t lost = lost_of(hole, hidden);
  if (hidden > 0) {
    past_[next_past_] = {hole, lost, true};
    next_past_ = (next_past_ + 1) % past_.size();
  }
  lost_ += static_cast<std::uint64_t>(lost);
  return new_losses();
}

/// Adds the unexplained parts of a hole as candidates of sectors.
void HiddenSectors::add_candidates(const StreamHole& hole) {
  const auto packet = static_cast<Hundredths>(hole.turned * hole.per_packet / hole.groups);
  Hundredths begin = hole.last;
  auto left = static_cast<Hundredths>(hole.turned) - ahead(hole.from, hole.last);
  // Every round but the last passes the end of a sector. A hole of less than a turn has every end once.
  for (std::size_t round = 0; round <= sectors_.size() && left >= smallest_candidate; ++round) {
    // The nearest sector ahead, or the one around `begin`.
    const Sector* next = nullptr;
    Hundredths to_next = left;
    for (const Sector& s : sectors_) {
      if (!s.used) continue;
      const bool within = ahead(s.from, begin) < s.width;
      const Hundredths distance = within ? 0 : ahead(begin, s.from);
      if (distance < to_next) next = &s, to_next = distance;
    }
    const Hundredths end = next != nullptr ? next->end() : 0;
    if (to_next >= smallest_candidate) add_sector(begin, to_next, packet);
    if (next == nullptr) return;
    left -= ahead(begin, end);
    begin = end;
  }
}

void HiddenSectors::add_sector(Hundredths from, Hundredths width, Hundredths packet) {
  for (Sector& s : sectors_) {
    if (s.used) continue;
    s = Sector{};
    s.from = from;
    s.width = width;
    s.packet = std::max(packet, 1);
    s.used = true;
    return;
  }
}

void HiddenSectors::learn(Hundredths from, Hundredths to, Hundredths packet) {
  const Hundredths width = ahead(from, to);
  Sector* place = nullptr;
  for (Sector& s : sectors_) {
    if (s.used && is_near(s.from, from) && is_near(s.end(), to)) {
      // The narrower one is right: no group was received inside it.
      if (!s.known) s.slack = same_edge;
      s.known = true;
      s.passes = std::max(s.passes, passes_against_bursts);
      return;
    }
    const bool overlaps = ahead(from, s.from) < width || ahead(s.from, from) < s.width;
    if (overlaps) s.used = false;
    if (!s.used) place = &s;
  }
  if (place == nullptr) place = &sectors_[0];
  *place = {from, width, std::max(packet, 1), same_edge, passes_against_bursts, true, true};
}

/// Splits a sector at a received group: only the parts beside it can be hidden.
void HiddenSectors::exclude(Sector& sector, Hundredths azimuth) {
  const Hundredths before = ahead(sector.from, azimuth);
  const Hundredths after = sector.width - before;
  const Hundredths smallest = sector.known ? smallest_sector : smallest_candidate;
  sector.slack -= std::min(before, after);
  if (sector.known && sector.slack < 0) {
    sector.used = false;
    // More than the edge was received. After few passes the holes were bursts of loss.
    if (sector.passes < passes_against_bursts) return;
    // After many passes the field of view was changed, and the past holes were hidden.
    past_ = {};
    seen_.reset();
    return;
  }
  const Sector whole = sector;
  if (before < after) sector.from = azimuth;
  sector.width = std::max(before, after);
  sector.used = sector.width >= smallest;
  if (whole.known || std::min(before, after) < smallest) return;
  add_sector(before < after ? whole.from : azimuth, std::min(before, after), whole.packet);
}

bool HiddenSectors::exclude(Hundredths azimuth) {
  bool moved = false;
  for (Sector& s : sectors_) {
    if (!s.used || !is_inside(azimuth, s.from, s.width)) continue;
    moved = true;
    exclude(s, azimuth);
  }
  return moved;
}

std::uint64_t HiddenSectors::receive(const PacketAzimuths& azimuths) {
  ++received_;
  bool moved = false;
  // Most streams have no sectors; the check is cheap.
  const bool any = std::any_of(sectors_.begin(), sectors_.end(), [](const Sector& s) { return s.used; });
  for (std::size_t g = 0; g < azimuths.groups; ++g) {
    if (any) moved = exclude(azimuths.group[g]) || moved;
    seen_[static_cast<std::size_t>(azimuths.group[g] / 100)] = true;
  }
  const double packet_deg = azimuths.step_deg * static_cast<double>(azimuths.groups);
  for (std::size_t g = 1; g < azimuths.groups && azimuths.hidden_total_deg > 0; ++g) {
    if (azimuths.hidden_deg[g] <= 0) continue;
    learn(azimuths.group[g - 1], azimuths.group[g], static_cast<Hundredths>(packet_deg * 100));
  }
  if (moved) count_again();
  return new_losses();
}

/// True if more than one hole reached into the sector.
bool HiddenSectors::came_again(const Sector& sector) const {
  return std::count_if(past_.begin(), past_.end(), [&](const Past& past) {
           return past.used && groups_inside(past.hole, sector.from, sector.width) > 0;
         }) > 1;
}

/// Sensors have one field of view, so at most the widest uncertain sector is hidden. A hole that did not
/// recur is loss.
std::uint64_t HiddenSectors::finish() {
  const auto is_less = [](const Sector& a, const Sector& b) {
    return std::make_tuple(a.used, a.known, a.width) < std::make_tuple(b.used, b.known, b.width);
  };
  const Sector& likeliest = *std::max_element(sectors_.begin(), sectors_.end(), is_less);
  for (Sector& s : sectors_) {
    if (!s.known && (&s != &likeliest || !came_again(s) || was_seen(s) || could_be_chance(s))) s.used = false;
  }
  count_again();
  const std::uint64_t lost = new_losses();
  reset();
  return lost;
}

}  // namespace lidard::velodyne
