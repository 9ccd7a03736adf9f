// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/hidden_sectors.h"

#include <algorithm>
#include <cmath>

namespace lidard::velodyne {
namespace {

/// A narrower hole between packets is always loss.
constexpr Hundredths smallest_candidate = 1000;
/// An edge may move by this from turn to turn with the steps of the groups.
constexpr Hundredths same_edge = 100;
/// Half the step on the wire, for both ends of an interpolation.
constexpr Hundredths tolerance = 1;
constexpr int turns_for_certainty = 10;
/// Chance is excluded if it explains the holes in fewer than one of 1000 streams.
const double log_certainty = std::log(1e3);

/// From `a` clockwise to `b`, all in [0, whole_turn).
Hundredths ahead(Hundredths a, Hundredths b) {
  const Hundredths d = b - a;
  return d < 0 ? d + whole_turn : d;
}

template <class List, class Condition>
void erase_if(List& list, Condition&& condition) {
  list.erase(std::remove_if(list.begin(), list.end(), condition), list.end());
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
  if (width <= 2 * tolerance || hole.turned <= 0) return 0;
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
  for (const Sector& s : unseen_) hidden += groups_inside(hole, s.from, s.width);
  return hidden;
}

/// Recounts the pending holes with the current sectors.
void HiddenSectors::count_again() {
  for (PendingHole& pending : pending_) {
    const std::int64_t lost = lost_of(pending.hole, hidden_groups(pending.hole));
    if (lost > pending.counted)
      lost_ += static_cast<std::uint64_t>(lost - std::exchange(pending.counted, lost));
  }
  erase_if(pending_, [this](const PendingHole& pending) { return hidden_groups(pending.hole) == 0; });
}

/// The unseen sectors are hidden, whatever is received of them from now on.
void HiddenSectors::settle() {
  count_again();
  pending_.clear();
  certain_ = true;
}

std::uint64_t HiddenSectors::hole(const StreamHole& hole) {
  const std::int64_t hidden = hidden_groups(hole);
  const std::int64_t lost = lost_of(hole, hidden);
  if (hidden > 0 && !certain_ && pending_.size() < pending_.capacity()) pending_.push_back({hole, lost});
  lost_ += static_cast<std::uint64_t>(lost);
  return new_losses();
}

/// Splits the sector around a received group: only the parts beside it can be hidden. True if there is one.
bool HiddenSectors::exclude(Hundredths azimuth, Sectors& sectors) {
  for (Sector& s : sectors) {
    const Hundredths before = ahead(s.from, azimuth);
    const Hundredths after = s.width - before;
    if (before <= 0 || after <= 0) continue;
    // A sector that a packet has shown may be narrow.
    const auto is_kept = [&](Hundredths part, Hundredths other) {
      return part >= smallest_candidate || (part >= same_edge && other < same_edge);
    };
    const bool first = is_kept(before, after), second = is_kept(after, before);
    const Sector rest{azimuth, after};
    if (first) s.width = before;
    if (first && second) sectors.push_back(rest);
    if (!first && second) s = rest;
    if (!first && !second) sectors.erase(sectors.begin() + (&s - sectors.data()));
    return true;
  }
  return false;
}

/// A sensor has one field of view, so nothing outside of the gap is hidden.
void HiddenSectors::learn(const Sector& gap) {
  for (Sectors* sectors : {&unseen_, &recent_}) {
    erase_if(*sectors, [&](const Sector& s) { return ahead(gap.from, s.from) + s.width > gap.width; });
    if (sectors->empty()) sectors->push_back(gap);
  }
  settle();
}

/// Nothing of a sector was received for ten turns: it is hidden now, whatever was received before.
void HiddenSectors::count_turn(Hundredths azimuth) {
  const bool is_new = azimuth < last_ - same_edge;
  last_ = azimuth;
  const Sector all{azimuth, whole_turn};
  if (received_++ == 0) unseen_ = recent_ = {all};
  if (!is_new || ++turns_ < turns_for_certainty) return;
  unseen_ = std::exchange(recent_, {all});
  erase_if(unseen_, [this](const Sector& s) { return could_be_chance(s, turns_for_certainty); });
  settle();
  turns_ = 0;
}

std::uint64_t HiddenSectors::receive(const PacketAzimuths& azimuths) {
  count_turn(azimuths.group[0]);
  packet_ =
      std::max(1, static_cast<Hundredths>(azimuths.step_deg * 100 * static_cast<double>(azimuths.groups)));
  bool moved = false;
  const bool any = !unseen_.empty() || !recent_.empty();
  for (std::size_t g = 0; any && g < azimuths.groups; ++g) {
    moved = exclude(azimuths.group[g], unseen_) || moved;
    exclude(azimuths.group[g], recent_);
  }
  if (moved) count_again();
  for (std::size_t g = 1; g < azimuths.groups && azimuths.hidden_total_deg > 0; ++g) {
    if (azimuths.hidden_deg[g] > 0)
      learn({azimuths.group[g - 1], ahead(azimuths.group[g - 1], azimuths.group[g])});
  }
  return new_losses();
}

/// True if a stream that loses its packets at random may have so many holes over the sector.
bool HiddenSectors::could_be_chance(const Sector& sector, std::int64_t holes) const {
  const double all = static_cast<double>(received_ + lost_ + 1);
  // A stream without loss so far may still lose packets.
  const double share = std::max(static_cast<double>(lost_) / all, 1e-3);
  const double packets = static_cast<double>(holes) * sector.width / packet_;
  return packets * -std::log(share) < std::log(all) + log_certainty;
}

std::uint64_t HiddenSectors::finish() {
  if (!certain_ && !unseen_.empty()) {
    const Sector widest = *std::max_element(
        unseen_.begin(), unseen_.end(), [](const Sector& a, const Sector& b) { return a.width < b.width; });
    const auto holes = std::count_if(pending_.begin(), pending_.end(), [&](const PendingHole& pending) {
      return groups_inside(pending.hole, widest.from, widest.width) > 0;
    });
    unseen_.clear();
    if (holes > 1 && !could_be_chance(widest, holes)) unseen_.push_back(widest);
    count_again();
  }
  const std::uint64_t lost = new_losses();
  reset();
  return lost;
}

}  // namespace lidard::velodyne
