// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/visibility.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();
constexpr double passed_columns = 0.1;  // share of a step
constexpr std::uint16_t no_outline = 0xFFFF;
// m; between outlines that touch, rounding leaves shorter stretches that are none.
constexpr float rounding = 0.003F;

}  // namespace

Visibility::Visibility(const ScanGrid& grid, const VisibilitySettings& settings, std::size_t sources)
    : settings_(settings),
      raster_(grid),
      rays_(sources),
      sweep_kinds_(sources, seen),
      range_max_(static_cast<float>(grid.range_max)),
      approach_(static_cast<float>(std::max(settings.approach, 5 * settings.noise))),
      outline_of_(sources * kinds, no_outline),
      states_(grid.beams, BeamState::unobserved),
      covered_(grid.beams, 0),
      body_at_(grid.beams, infinite),
      blind_to_(grid.beams, 0),
      from_behind_(grid.beams, 0) {
  const double asked = settings_.free_required > 0 ? settings_.free_required : grid.range_max;
  open_ = std::min(static_cast<float>(asked), range_max_);
  begin();
}

void Visibility::set_footprint(const Footprint& footprint) { body_ = footprint.padded(Footprint::margin_m); }

void Visibility::begin() {
  nearest_.clear(beams());
  mixed_pixels_.clear(beams());
  outlines_.clear();
  std::fill(outline_of_.begin(), outline_of_.end(), no_outline);
  kind_of_.clear();
  has_columns_ = true;
  column_ = 0;
}

Outlines& Visibility::outlines(std::size_t source, Kind kind, double step, double distance) {
  // An object ends at least a quarter of an output's beam before a beam that passes it. Near its origin a
  // virtual scan is finer than the columns.
  const double passed = std::min(has_columns_ ? passed_columns : 0.5, raster_.grid().increment / 4 / step);
  // Beyond all ranges, as seen from every position that the source looks from.
  const double reach = 4 * (raster_.grid().range_max + distance);
  if (has_columns_) column_ = std::max(column_, static_cast<float>(step));
  std::uint16_t& outline = outline_of_[source * kinds + kind];
  if (outline == no_outline) {
    outline = static_cast<std::uint16_t>(kind_of_.size());
    kind_of_.push_back(kind);
  }
  outlines_.set_source(outline, static_cast<float>(passed), static_cast<float>(reach));
  return outlines_;
}

void Visibility::compute(const std::vector<const PlacedScan*>& sweeps) {
  begin();
  has_columns_ = false;
  for (std::size_t s = 0; s < sweeps.size(); ++s) {
    if (sweeps[s] == nullptr) continue;
    const BeamRays& rays = rays_[s];
    outlines(s, sweep_kinds_[s], std::abs(rays.increment), rays.pose.translation().norm())
        .add_sweep(rays, *sweeps[s]);
    raster_.draw(*sweeps[s], nearest_);
    raster_.draw_mixed_pixels(*sweeps[s], mixed_pixels_);
  }
  compute();
}

void Visibility::compute() {
  add_vehicle(body_);
  if (former_from_now_) add_vehicle(body_.transformed(former_from_now_->inverse()));
  crossings_.find(outlines_, raster_, kind_of_.size());
  layers_.resize(kind_of_.size());
  for (std::size_t beam = 0; beam < beams(); ++beam) states_[beam] = decide(beam);
}

void Visibility::add_vehicle(const Footprint& body) {
  outlines_.add_polygon(kind_of_.size(), body);
  kind_of_.push_back(seen);
}

/// m from the return that hides what lies behind an edge to where the beam crosses the edge.
float Visibility::behind(std::size_t beam, const Crossings::Crossing& crossing) const {
  const Outlines::Edge& edge = outlines_.edges[crossing.edge];
  const float at = crossing.at;
  if (edge.near == Outlines::Edge::both) return 0;
  const std::uint32_t near = edge.near == Outlines::Edge::at_from ? edge.from : edge.to;
  return std::hypot(at * raster_.cosine(beam) - outlines_.x[near],
                    at * raster_.sine(beam) - outlines_.y[near]);
}

void Visibility::begin_walk(Walk& walk) {
  const Crossings::Layers* const at_origin = crossings_.at_origin(walk.beam);
  for (std::size_t s = 0; s < layers_.size(); ++s) {
    const int free = at_origin[s].free, hidden = at_origin[s].hidden;
    layers_[s] = {free, hidden, infinite};
    walk.free[kind_of_[s]] += free > 0 ? 1 : 0;
    walk.hidden += hidden > 0 ? 1 : 0;
  }
}

void Visibility::cross(Walk& walk, const Crossings::Crossing& crossing) {
  Layers& layers = layers_[crossing.source];
  const bool was_free = layers.free > 0, was_hidden = layers.hidden > 0, was_any = walk.is_free();
  layers.free += crossing.free;
  layers.hidden += crossing.hidden;
  const bool is_free = layers.free > 0, is_hidden = layers.hidden > 0;
  if (is_hidden && !was_hidden) layers.behind = behind(walk.beam, crossing);
  walk.hidden += is_hidden == was_hidden ? 0 : is_hidden ? 1 : -1;
  if (is_free == was_free) return;
  walk.free[kind_of_[crossing.source]] += is_free ? 1 : -1;
  if (was_any && !walk.is_free()) walk.stretch = {crossing.at, infinite, infinite};
  if (!was_any && walk.is_free()) end_unseen(walk, crossing.at);
}

/// A part of a stretch that no source sees.
void Visibility::pass_unseen(Walk& walk, float from, float to) const {
  if (walk.hidden == 0 || to - from <= rounding) return;
  float nearest = infinite;
  for (const Layers& layers : layers_) {
    if (layers.hidden > 0) nearest = std::min(nearest, layers.behind);
  }
  walk.stretch.hidden_from = std::min(walk.stretch.hidden_from, from);
  if (walk.free[over] == 0) walk.stretch.behind = std::min(walk.stretch.behind, nearest);
}

void Visibility::end_unseen(Walk& walk, float to) {
  const Unseen& stretch = walk.stretch;
  if (to - stretch.from <= rounding) return;
  bool accepted = false;
  if (stretch.hidden_from == infinite) {
    const float most =
        std::max(static_cast<float>(settings_.gap), static_cast<float>(settings_.gap_share) * to);
    walk.unseen += to - stretch.from;
    accepted = walk.has_hit && to - stretch.from <= most && walk.unseen <= 2 * most;
  } else if (stretch.behind <= static_cast<float>(settings_.gap) / 2) {
    body_at_[walk.beam] = stretch.hidden_from;
  }
  if (accepted) return;
  covered_[walk.beam] = stretch.from;
  walk.covered = false;
}

BeamState Visibility::decide(std::size_t beam) {
  Walk walk{beam, has_hit(beam), open_};
  if (walk.has_hit) walk.end = nearest_.range[beam] * (1 - column_) - approach_;
  body_at_[beam] = infinite;
  from_behind_[beam] = 0;
  blind_to_[beam] = 0;
  covered_[beam] = std::max(walk.end, 0.0F);
  begin_walk(walk);
  float at = 0;
  const auto pass = [&](float to) {
    if (!walk.is_free()) pass_unseen(walk, at, to);
    if (walk.is_blind() && to - at > rounding) blind_to_[beam] = to;
    if (walk.is_front() && at - walk.front_to > rounding) walk.front_from = at;
    if (walk.is_front()) walk.front_to = to;
    at = to;
  };
  for (const Crossings::Crossing& crossing : crossings_.of(beam)) {
    if (crossing.at >= walk.end || !walk.covered) break;
    pass(crossing.at);
    cross(walk, crossing);
  }
  if (walk.end > at && walk.covered) {
    pass(walk.end);
    if (!walk.is_free()) end_unseen(walk, walk.end);
    // What is hidden as far as the surface says nothing of the side of the beam, unless the thing is thin.
    const float hidden_from = walk.stretch.hidden_from;
    if (settings_.one_level && !walk.is_free() && walk.end - hidden_from > static_cast<float>(settings_.gap))
      from_behind_[beam] = 1;
    if (walk.has_hit && walk.is_front()) {
      body_at_[beam] = std::min(body_at_[beam], walk.front_from);
      walk.covered = false;
    }
  }
  if (!walk.has_hit) return walk.covered ? BeamState::free : BeamState::unobserved;
  if (!walk.covered) return BeamState::gap;
  return walk.is_free() || walk.end <= rounding ? BeamState::hit : BeamState::behind;
}

void Visibility::encode(Profile profile, PlanarScan& scan, bool with_intensities) const {
  raster_.grid().prepare(scan, with_intensities);
  for (std::size_t beam = 0; beam < beams(); ++beam) {
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
      hit = range <= scan.range_max && (from_behind_[beam] == 0 || range < nearest_.range[beam]);
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
  if (!has_columns_) return;
  scan.free_from.assign(beams(), 0);
  for (std::size_t beam = 0; beam < beams(); ++beam) {
    if (scan.statuses[beam] != BeamStatus::hit) continue;
    // If the way to a hit is not known to be free, the hit proves no free space.
    const float range = scan.ranges[beam];
    scan.free_from[beam] = states_[beam] == BeamState::hit ? std::min(blind_to_[beam], range) : range;
  }
}

}  // namespace lidard
