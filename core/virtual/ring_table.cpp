// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/virtual/ring_grid.h"

namespace lidard {
namespace {

// Nearer returns stand too close to the optics to tell the direction of their beam.
constexpr float telling_range_m = 2;
// After the first cloud one column in so many is looked at, others each time.
constexpr std::size_t sampled = 211;
// Beyond that many returns old ones count less, so that a changed speed of rotation is followed.
constexpr double memory = 2000;

bool is_telling(const CloudPoint& p) {
  return p.x * p.x + p.y * p.y > telling_range_m * telling_range_m && std::isfinite(p.z);
}

float elevation_of(const CloudPoint& p) { return fast_atan2(p.z, std::sqrt(p.x * p.x + p.y * p.y)); }

}  // namespace

void RingTable::set_rings(std::size_t rings) {
  if (rings == rings_.size()) return;
  rings_.assign(rings, {});
  clouds_ = 0;
}

void RingTable::take(const Cloud& cloud, std::size_t begin, std::size_t end, const CloudColumn* column) {
  for (std::size_t i = begin; i < end; ++i) {
    const CloudPoint& p = cloud.points()[i];
    if (p.ring >= rings_.size() || !is_telling(p)) continue;
    Ring& ring = rings_[p.ring];
    ring.elevations += static_cast<double>(elevation_of(p));
    ring.count += 1;
    if (column == nullptr) continue;
    // Azimuth counts clockwise.
    const float behind = fast_atan2(-p.y, p.x) - wrapped(column->azimuth);
    ring.offsets += static_cast<double>(wrapped(behind));
  }
}

void RingTable::fade() {
  for (Ring& ring : rings_) {
    if (ring.count < memory) continue;
    const double keep = memory / 2 / ring.count;
    ring = {ring.elevations * keep, ring.offsets * keep, memory / 2};
  }
}

void RingTable::learn(const Cloud& cloud, bool with_offsets) {
  const std::size_t step = clouds_ == 0 ? 1 : sampled;
  const std::size_t first = clouds_ == 0 ? 0 : clouds_ % sampled;
  ++clouds_;
  if (!with_offsets) {
    for (std::size_t i = first; i < cloud.size(); i += step) take(cloud, i, i + 1, nullptr);
  } else {
    for (std::size_t c = first; c < cloud.columns.size(); c += step) {
      take(cloud, cloud.columns[c].first_point, cloud.points_end(c), &cloud.columns[c]);
    }
  }
  fade();
}

void find_rings(const Cloud& cloud, std::vector<float>& elevations) {
  constexpr std::size_t bins = 3600;  // of 0.05 degrees
  constexpr std::size_t most_rings = 128;
  constexpr float width = static_cast<float>(pi_d) / static_cast<float>(bins);
  std::vector<std::size_t> counts(bins, 0);
  std::size_t all = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint& p = cloud.points()[i];
    if (!is_telling(p)) continue;
    const auto at = (elevation_of(p) + static_cast<float>(pi_d / 2)) / width;
    ++counts[std::min(static_cast<std::size_t>(at), bins - 1)];
    ++all;
  }
  elevations.clear();
  std::size_t in_groups = 0;
  for (std::size_t begin = 0; begin < bins;) {
    std::size_t end = begin;
    std::size_t count = 0;
    float sum = 0;
    for (; end < bins && counts[end] > 0; ++end) {
      count += counts[end];
      sum += static_cast<float>(counts[end]) * (static_cast<float>(end) + 0.5F);
    }
    // A ring is narrow, and no stray return.
    if (end - begin <= 6 && count * 1000 > all) {
      elevations.push_back(sum / static_cast<float>(count) * width - static_cast<float>(pi_d / 2));
      in_groups += count;
    }
    begin = end + 1;
  }
  if (elevations.size() < 2 || elevations.size() > most_rings || in_groups * 10 < all * 9) elevations.clear();
}

}  // namespace lidard
