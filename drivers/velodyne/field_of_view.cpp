// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/field_of_view.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lidard::velodyne {
namespace {

/// A narrower hole between packets is always loss, as long as no field of view is known.
constexpr Hundredths smallest_sector = 1000;
constexpr Hundredths smallest_known = 100;
/// Half the wire's step, for both ends of an interpolation.
constexpr Hundredths tolerance = 1;
/// An edge moves by so much from turn to turn, since the firings stand elsewhere.
constexpr Hundredths same_edge = 100;
/// Holes in succession at one place that make it a field of view, until something comes from there.
constexpr int enough_holes = 4;
/// Holes over one sector that bursts of lost packets do not leave by chance.
constexpr std::int64_t too_many_for_bursts = 10;
constexpr std::size_t most_doubts = 64;
constexpr std::size_t most_sectors = whole_turn / smallest_known;

/// From `a` clockwise to `b`, all in [0, whole_turn).
Hundredths ahead(Hundredths a, Hundredths b) { return b < a ? b - a + whole_turn : b - a; }

bool is_near(Hundredths a, Hundredths b) { return std::min(ahead(a, b), ahead(b, a)) < same_edge; }

}  // namespace

FieldOfView::FieldOfView() {
  unseen_.reserve(most_sectors);
  doubts_.reserve(most_doubts);
}

bool FieldOfView::overlap(const Sector& a, const Sector& b) {
  return ahead(a.from, b.from) < a.width || ahead(b.from, a.from) < b.width;
}

/// Groups of the hole inside a sector, in all its turns together. Group g stands at g * turned / groups after
/// the begin of the hole; whole numbers need no rounding. A hole lasts some seconds at most, so that all
/// products stay far below 64 bits.
std::int64_t FieldOfView::groups_inside(const StreamHole& hole, const Sector& sector) {
  std::int64_t inside = 0;
  // The sector may have begun in the turn before the hole.
  for (std::int64_t from = ahead(hole.from, sector.from) - whole_turn; from < hole.turned;
       from += whole_turn) {
    const std::int64_t begin = (from + tolerance) * hole.groups;
    const std::int64_t end = (from + sector.width - tolerance) * hole.groups;
    if (end <= 0) continue;
    const std::int64_t first = begin < 0 ? 0 : begin / hole.turned + 1;
    const std::int64_t after = std::min(hole.groups, (end + hole.turned - 1) / hole.turned);
    inside += std::max<std::int64_t>(0, after - first);
  }
  return inside;
}

std::int64_t FieldOfView::holes_over(const Sector& sector) const {
  return std::count_if(doubts_.begin(), doubts_.end(),
                       [&](const Doubt& doubt) { return groups_inside(doubt.hole, sector) > 0; });
}

/// The user changed the field of view: what was hidden there until now was no loss.
void FieldOfView::forget_holes_over(const Sector& sector) {
  const auto is_over = [&](const Doubt& doubt) { return groups_inside(doubt.hole, sector) > 0; };
  doubts_.erase(std::remove_if(doubts_.begin(), doubts_.end(), is_over), doubts_.end());
}

/// Packets of the hole that are lost as far as is known; `in_doubt` becomes its groups in unseen sectors.
std::int64_t FieldOfView::lost_of(const StreamHole& hole, std::int64_t& in_doubt) const {
  in_doubt = 0;
  for (const Sector& sector : unseen_) in_doubt += groups_inside(hole, sector);
  const double packets = static_cast<double>(hole.groups - in_doubt) / static_cast<double>(hole.per_packet);
  return std::max<std::int64_t>(0, std::llround(packets) - 1);
}

std::uint64_t FieldOfView::count_again() {
  std::int64_t found = 0;
  for (std::size_t i = doubts_.size(); i-- > 0;) {
    std::int64_t in_doubt = 0;
    const std::int64_t lost = std::max(lost_of(doubts_[i].hole, in_doubt), doubts_[i].counted);
    found += lost - doubts_[i].counted;
    doubts_[i].counted = lost;
    if (in_doubt == 0) doubts_.erase(doubts_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return static_cast<std::uint64_t>(found);
}

std::uint64_t FieldOfView::hole(const StreamHole& hole) {
  const Hundredths to_last = ahead(hole.from, hole.last);
  if (hole.turned >= to_last + smallest_sector && hole.turned < whole_turn) {
    const Sector now{hole.last, static_cast<Hundredths>(hole.turned) - to_last};
    const bool recurs = is_near(now.from, wide_.from) &&
                        is_near((now.from + now.width) % whole_turn, (wide_.from + wide_.width) % whole_turn);
    times_ = recurs ? times_ + 1 : 1;
    wide_ = now;
    if (times_ >= enough_holes) add(now);
  }
  std::int64_t in_doubt = 0;
  const std::int64_t lost = hole.turned > 0 ? lost_of(hole, in_doubt) : 0;
  if (in_doubt > 0) {
    if (doubts_.size() == most_doubts) doubts_.erase(doubts_.begin());
    doubts_.push_back({hole, lost});
  }
  return static_cast<std::uint64_t>(lost);
}

/// This sector is hidden by a field of view.
void FieldOfView::add(const Sector& sector) {
  for (std::size_t i = unseen_.size(); i-- > 0;) {
    if (!overlap(unseen_[i], sector)) continue;
    if (unseen_[i].width + 2 * same_edge >= sector.width) return;
    unseen_.erase(unseen_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  if (unseen_.size() < most_sectors) unseen_.push_back(sector);
}

/// Something came from everywhere in the closed sector. True if holes in doubt have to be counted again.
bool FieldOfView::see(Hundredths from, Hundredths width) {
  const Sector middle{(known_.from + same_edge) % whole_turn, known_.width - 2 * same_edge};
  if (middle.width > 0 && overlap(middle, {from, width})) forget_holes_over(std::exchange(known_, {}));
  const Hundredths smallest = known_.width > 0 ? smallest_known : smallest_sector;
  bool changed = false;
  for (std::size_t i = unseen_.size(); i-- > 0;) {
    const Sector whole = unseen_[i];
    const Hundredths before = ahead(whole.from, from);
    const bool is_inside = before < whole.width;
    const Hundredths behind = whole.width - before - width + (is_inside ? 0 : whole_turn);
    if (behind >= whole.width) continue;
    if (holes_over(whole) >= too_many_for_bursts) forget_holes_over(whole);
    unseen_.erase(unseen_.begin() + static_cast<std::ptrdiff_t>(i));
    if (is_inside && before >= smallest) unseen_.push_back({whole.from, before});
    if (behind >= smallest && unseen_.size() < most_sectors)
      unseen_.push_back({(from + width) % whole_turn, behind});
    changed = true;
  }
  return changed;
}

std::uint64_t FieldOfView::receive(const PacketAzimuths& azimuths) {
  if (!started_) unseen_.push_back({azimuths.group[0], whole_turn});
  started_ = true;
  // Most streams have no field of view, and this is done for every packet.
  if (unseen_.empty() && azimuths.hidden_total_deg <= 0) return 0;
  bool changed = false;
  std::size_t first = 0;
  for (std::size_t g = 1; g <= azimuths.groups; ++g) {
    const bool is_hidden = g < azimuths.groups && azimuths.hidden_deg[g] > 0;
    if (g < azimuths.groups && !is_hidden) continue;
    // A motor that stands still may seem to turn back a little.
    const Hundredths turned = ahead(azimuths.group[first], azimuths.group[g - 1]);
    changed = see(azimuths.group[first], turned < whole_turn / 2 ? turned : 0) || changed;
    first = g;
    if (!is_hidden) continue;
    known_ = {azimuths.group[g - 1], ahead(azimuths.group[g - 1], azimuths.group[g])};
    add(known_);
  }
  return changed ? count_again() : 0;
}

std::uint64_t FieldOfView::finish() {
  const auto is_narrower = [](const Sector& a, const Sector& b) { return a.width < b.width; };
  const auto widest = std::max_element(unseen_.begin(), unseen_.end(), is_narrower);
  const bool is_view = widest != unseen_.end() && (known_.width > 0 || holes_over(*widest) > 1);
  unseen_.assign(is_view ? 1 : 0, is_view ? Sector(*widest) : Sector());
  const std::uint64_t found = count_again();
  reset();
  return found;
}

}  // namespace lidard::velodyne
