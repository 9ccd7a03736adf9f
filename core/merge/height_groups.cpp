// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/height_groups.h"

#include <algorithm>
#include <numeric>

namespace lidard {
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
