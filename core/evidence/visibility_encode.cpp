// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cassert>

#include "core/evidence/visibility.h"

namespace lidard {

bool Visibility::is_seen_all_along(std::size_t beam) const {
  constexpr float apart = 0.01F;  // m
  for (float at = begin_[beam] + apart; at < ways_[beam]; at += apart) {
    const auto begin = inside_.begin();
    if (std::any_of(begin + pieces_[beam], begin + pieces_[beam + 1],
                    [&](const Inside& body) { return at > table_.edge(body.from) && at < body.end; }))
      continue;
    bool seen = was_inside(beam, at);
    // A beam may lie on the border of two cells.
    for (const float turn : {-1e-5F, 1e-5F}) {
      const float c = raster_.cosine(beam) - turn * raster_.sine(beam);
      const float d = raster_.sine(beam) + turn * raster_.cosine(beam);
      for (std::size_t s = 0; s < observing_ && !seen; ++s)
        seen = maps_[s].size() > 0 && maps_[s].is_free(maps_[s].place_of(at * c, at * d));
    }
    if (!seen) return false;
  }
  return true;
}

void Visibility::encode(Profile profile, PlanarScan& scan, bool with_intensities) const {
  raster_.grid().prepare(scan, with_intensities);
  for (std::size_t beam = 0; beam < beams(); ++beam) {
    assert(states_[beam] != BeamState::free || is_seen_all_along(beam));
    float range = nearest_.range[beam];
    float intensity = nearest_.intensity[beam];
    bool hit = states_[beam] == BeamState::hit;
    bool free = states_[beam] == BeamState::free;
    if (profile == Profile::safety) {
      if (mixed_pixels_.range[beam] < range) {
        range = mixed_pixels_.range[beam];
        intensity = mixed_pixels_.intensity[beam];
      }
      // The object may be the one that was hit, seen from its other side.
      if (body_at_[beam] + static_cast<float>(settings_.gap) + approach_ < range) {
        range = body_at_[beam];
        intensity = 0;
      }
      hit = range <= scan.range_max;
      free = free && !hit;
    }
    if (free) scan.set_without_hit(beam, BeamStatus::none);
    if (!hit) continue;
    if (range < scan.range_min) {
      scan.set_without_hit(beam, BeamStatus::near);
    } else {
      scan.set_hit(beam, range);
      if (with_intensities) scan.intensities[beam] = intensity;
    }
  }
  if (observing_ == maps_.size()) return;
  scan.free_from.assign(beams(), 0);
  for (std::size_t beam = 0; beam < beams(); ++beam) {
    if (scan.statuses[beam] != BeamStatus::hit) continue;
    // If the way to a hit is not known to be free, the hit proves no free space.
    const float range = scan.ranges[beam];
    scan.free_from[beam] = states_[beam] == BeamState::hit ? std::min(blind_to_[beam], range) : range;
  }
}

}  // namespace lidard
