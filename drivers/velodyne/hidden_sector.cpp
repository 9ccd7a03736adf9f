// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/hidden_sector.h"

#include <algorithm>
#include <cmath>

namespace lidard::velodyne {
namespace {

/// A narrower hole between packets is always loss.
constexpr Hundredths narrowest = 1000;
/// An edge may move by this from turn to turn with the steps of the groups.
constexpr Hundredths same_edge = 100;
/// A narrower unseen sector is a step between groups.
constexpr Hundredths finest = 50;
/// Half the step on the wire, for both ends of an interpolation.
constexpr Hundredths tolerance = 1;
/// Turns that are counted one by one; a longer hole is a pause, or a stamp of a wrong clock.
constexpr std::int64_t most_turns = 1000;
constexpr int turns_for_certainty = 10;
/// If every second packet is lost, 18 packets in turn are lost once in 2^18 times: more is no chance.
constexpr std::int64_t beyond_chance = 18;

/// From `a` clockwise to `b`, all in [0, whole_turn).
Hundredths ahead(Hundredths a, Hundredths b) { return b < a ? b - a + whole_turn : b - a; }

}  // namespace

/// Groups of the hole inside a sector, in all its turns. Group g is at g * turned / groups after the hole's
/// begin; integers avoid rounding, and all products fit into 64 bits. Of a hole with
/// more turns the sector's share is taken.
std::int64_t HiddenSector::groups_inside(const StreamHole& hole, const Sector& sector) {
  const std::int64_t width = sector.width - 2 * tolerance;
  if (width <= 0 || hole.turned <= 0) return 0;
  if (hole.turned > most_turns * whole_turn) return hole.groups * width / whole_turn;
  // Groups up to an angle after the hole's begin, without one that is exactly there.
  const auto groups_before = [&hole](std::int64_t angle) {
    const std::int64_t groups = (angle * hole.groups + hole.turned - 1) / hole.turned;
    return std::clamp<std::int64_t>(angle <= 0 ? 0 : groups, 0, hole.groups);
  };
  std::int64_t inside = 0;
  std::int64_t begin = ahead(hole.from, sector.from) + tolerance - whole_turn;
  for (; begin < hole.turned; begin += whole_turn)
    inside += groups_before(begin + width) - groups_before(begin + 1);
  return inside;
}

std::uint64_t HiddenSector::lost_of(const StreamHole& hole, const Sector& hidden) {
  const std::int64_t groups = hole.groups - groups_inside(hole, hidden);
  const double packets = static_cast<double>(groups) / static_cast<double>(hole.per_packet);
  return static_cast<std::uint64_t>(std::max<std::int64_t>(1, std::llround(packets)) - 1);
}

/// The widest sector that nothing was received of in these turns, within an arc; none of at most `least`:
/// only every such step is looked at, and a wider sector contains one.
HiddenSector::Sector HiddenSector::widest_unseen(const Sector& arc, Hundredths least) const {
  const auto is_edge = [&](Hundredths on) {
    return on == 0 || on == arc.width || seen_[static_cast<std::size_t>((arc.from + on) % whole_turn)];
  };
  Sector widest;
  for (Hundredths on = least; on < arc.width; on += least) {
    if (is_edge(on)) continue;
    Hundredths begin = on;
    while (!is_edge(begin)) --begin;
    while (!is_edge(on)) ++on;
    if (on - begin > widest.width) widest = {(arc.from + begin) % whole_turn, on - begin};
  }
  return widest;
}

/// Of the whole turn, if it is wide enough to be hidden between packets.
HiddenSector::Sector HiddenSector::widest_unseen() const {
  const Sector widest = widest_unseen({last_, whole_turn}, narrowest);
  return widest.width > narrowest ? widest : Sector();
}

/// The sector is known. Returns the lost packets of the holes that waited.
std::uint64_t HiddenSector::settle(const Sector& hidden) {
  hidden_ = hidden;
  is_known_ = true;
  std::uint64_t lost = 0;
  for (const StreamHole& hole : waiting_) lost += lost_of(hole, hidden_);
  waiting_.clear();
  return lost;
}

std::uint64_t HiddenSector::hole(const StreamHole& hole) {
  const bool waits = !is_known_ && hole.turned > narrowest && waiting_.size() < waiting_.capacity();
  if (!waits) return lost_of(hole, hidden_);
  waiting_.push_back(hole);
  return 0;
}

std::uint64_t HiddenSector::end_turn() {
  if (++turns_ == turns_for_certainty) {
    turns_ = 0;
    const bool holds = widest_unseen(hidden_, finest).width == hidden_.width && hidden_.width > 0;
    const std::uint64_t lost = settle(holds ? hidden_ : widest_unseen());
    seen_.reset();
    return lost;
  }
  const auto waits = [this](const StreamHole& hole) {
    const auto turned = static_cast<Hundredths>(std::min<std::int64_t>(hole.turned, whole_turn));
    return widest_unseen({hole.from, turned}, narrowest).width > narrowest;
  };
  const auto lost_begin = std::stable_partition(waiting_.begin(), waiting_.end(), waits);
  std::uint64_t lost = 0;
  for (auto hole = lost_begin; hole != waiting_.end(); ++hole) lost += lost_of(*hole, {});
  waiting_.erase(lost_begin, waiting_.end());
  return lost;
}

std::uint64_t HiddenSector::receive(const PacketAzimuths& azimuths) {
  std::uint64_t lost = 0;
  if (azimuths.group[0] < last_ - same_edge) lost += end_turn();
  last_ = azimuths.group[0];
  packet_ =
      std::max(1, static_cast<Hundredths>(azimuths.step_deg * 100 * static_cast<double>(azimuths.groups)));
  for (std::size_t g = 0; g < azimuths.groups; ++g) seen_.set(static_cast<std::size_t>(azimuths.group[g]));
  if (azimuths.hidden_total_deg <= 0) return lost;
  for (std::size_t g = 1; g < azimuths.groups; ++g) {
    const Hundredths before = azimuths.group[g - 1];
    if (azimuths.hidden_deg[g] > 0)
      lost += settle(widest_unseen({before, ahead(before, azimuths.group[g])}, finest));
  }
  return lost;
}

std::uint64_t HiddenSector::finish() {
  Sector hidden = is_known_ ? hidden_ : widest_unseen();
  const auto passed = std::count_if(waiting_.begin(), waiting_.end(),
                                    [&](const StreamHole& hole) { return groups_inside(hole, hidden) > 0; });
  const bool recurred = passed > 1 && passed * hidden.width > beyond_chance * packet_;
  const std::uint64_t lost = settle(is_known_ || recurred ? hidden : Sector());
  reset();
  return lost;
}

}  // namespace lidard::velodyne
