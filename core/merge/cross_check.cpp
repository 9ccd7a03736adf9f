// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/cross_check.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lidard {
namespace {

constexpr double least_margin = 0.1;  // m
constexpr double margin_in_sigmas = 5;

}  // namespace

CrossCheck::CrossCheck(const MergeOptions& options, std::size_t sources, double range_max, double noise)
    : options_(options),
      unit_(FreeSpaceMap::unit_for(range_max)),
      margin_(static_cast<float>(std::max(least_margin, margin_in_sigmas * noise))),
      sources_(sources) {}

void CrossCheck::set_source(std::size_t index, const BeamRays& rays) {
  Source& source = sources_[index];
  source.map.set_source(rays, unit_);
  source.two_beams = static_cast<float>(2 * std::abs(rays.increment));
}

bool CrossCheck::sees_through(const Source& source, float x, float y) const {
  const float dx = x - source.map.x();
  const float dy = y - source.map.y();
  const float away = std::sqrt(dx * dx + dy * dy);
  const std::uint16_t here = source.map.distance(away);
  const std::uint16_t behind = source.map.distance(away + margin_);
  for (const float side : {0.0F, -source.two_beams, source.two_beams}) {
    const std::uint16_t cell = source.map.cell_towards(dx - side * dy, dy + side * dx);
    if (!source.map.is_free({cell, here}) || !source.map.is_free({cell, behind})) return false;
  }
  return true;
}

void CrossCheck::unlink(std::size_t beam, PlacedScan& sweep) {
  sweep.linked[beam] = 0;
  if (beam > 0) sweep.linked[beam - 1] = 0;
}

void CrossCheck::check_source(std::size_t index, const std::vector<const PlacedScan*>& sweeps,
                              const std::vector<Stamp>& ends) {
  PlacedScan& checked = sources_[index].checked;
  for (std::size_t beam = 0; beam < checked.kind.size(); ++beam) {
    if (checked.kind[beam] == Return::nothing) continue;
    bool seen_through = false;
    bool outdated = false;
    for (std::size_t s = 0; s < sources_.size(); ++s) {
      if (s == index || sweeps[s] == nullptr) continue;
      if (!sees_through(sources_[s], checked.x[beam], checked.y[beam])) continue;
      seen_through = true;
      outdated = outdated || ends[s] > ends[index];
    }
    if (options_.newest_wins && outdated) {
      checked.kind[beam] = Return::nothing;
      ++conflicts_;
    } else if (options_.veil_cross_check && seen_through && checked.kind[beam] == Return::surface) {
      checked.kind[beam] = Return::doubtful;
      ++veils_;
    } else {
      continue;
    }
    unlink(beam, checked);
  }
  const auto cut = [&](const PlacedScan::Corner& corner) { return checked.linked[corner.beam] == 0; };
  checked.corners.erase(std::remove_if(checked.corners.begin(), checked.corners.end(), cut),
                        checked.corners.end());
}

void CrossCheck::check(std::vector<const PlacedScan*>& sweeps, const std::vector<Stamp>& ends) {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (sweeps[s] != nullptr) sources_[s].map.fill(*sweeps[s]);
  }
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (sweeps[s] == nullptr) continue;
    sources_[s].checked = *sweeps[s];
    check_source(s, sweeps, ends);
  }
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (sweeps[s] != nullptr) sweeps[s] = &sources_[s].checked;
  }
}

namespace {

constexpr double one_height = 0.1;  // m

}  // namespace

HeightGroups::HeightGroups(const ScanGrid& grid, const VisibilitySettings& settings, std::size_t sources)
    : grid_(grid), settings_(settings), members_(sources), of_group_(sources, nullptr) {}

void HeightGroups::set_footprint(const Footprint& footprint) {
  footprint_ = footprint;
  for (Visibility& visibility : groups_) visibility.set_footprint(footprint);
}

void HeightGroups::set_source(std::size_t source, const BeamRays& rays) {
  members_[source].known = true;
  members_[source].rays = rays;
  grouped_ = false;
}

void HeightGroups::group() {
  const auto height = [this](std::size_t s) { return members_[s].rays.pose.translation().z(); };
  std::vector<std::size_t> order(members_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return height(a) < height(b); });
  groups_.clear();
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool next_height = i > 0 && height(order[i]) - height(order[i - 1]) > one_height;
    if (i == 0 || next_height) {
      groups_.emplace_back(grid_, settings_, members_.size());
      groups_.back().set_footprint(footprint_);
    }
    members_[order[i]].group = groups_.size() - 1;
    groups_.back().set_source(order[i], members_[order[i]].rays);
  }
  grouped_ = true;
}

void HeightGroups::require(const std::vector<const PlacedScan*>& sweeps, Visibility& visibility) {
  const bool all_known =
      std::all_of(members_.begin(), members_.end(), [](const Member& m) { return m.known; });
  if (!all_known) {
    for (std::size_t beam = 0; beam < visibility.beams(); ++beam) visibility.withdraw_free(beam, 0);
    return;
  }
  if (!grouped_) group();
  if (groups_.size() < 2) return;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    for (std::size_t s = 0; s < members_.size(); ++s)
      of_group_[s] = members_[s].group == g ? sweeps[s] : nullptr;
    groups_[g].compute(of_group_);
    for (std::size_t beam = 0; beam < visibility.beams(); ++beam) {
      if (groups_[g].state(beam) != BeamState::free) visibility.withdraw_free(beam, groups_[g].covered(beam));
    }
  }
}

}  // namespace lidard
