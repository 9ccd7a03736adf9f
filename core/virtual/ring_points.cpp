// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The part of RingGrid for clouds without firing columns: of other drivers, and of scanners that measure one
// plane after the other.

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/angle.h"
#include "core/virtual/ring_grid.h"

namespace lidard {
namespace {

// Nearer returns are too close to the optics to determine the direction of their beam.
constexpr float direction_range_m = 2;
// After the first cloud one column in this number is sampled, others in every cloud.
constexpr std::size_t sampled = 211;
// Beyond this number of returns old ones decay, so that the table follows a changed speed of rotation.
constexpr double memory = 2000;

bool shows_direction(const CloudPoint& p) {
  return p.x * p.x + p.y * p.y > direction_range_m * direction_range_m && std::isfinite(p.z);
}

float elevation_of(const CloudPoint& p) { return fast_atan2(p.z, std::sqrt(p.x * p.x + p.y * p.y)); }

}  // namespace

void RingTable::set_rings(const Cloud& cloud) {
  if (cloud.rings == rings_.size()) return;
  rings_.assign(cloud.rings, {});
  clouds_ = 0;
  // They count as one return.
  for (std::size_t r = 0; r < std::min(rings_.size(), cloud.directions.size()); ++r)
    rings_[r] = {cloud.directions[r].elevation, cloud.directions[r].ahead, 1};
}

void RingTable::add(const Cloud& cloud, std::size_t begin, std::size_t end, const CloudColumn* column) {
  for (std::size_t i = begin; i < end; ++i) {
    const CloudPoint& p = cloud.points()[i];
    if (p.ring >= rings_.size() || !shows_direction(p)) continue;
    Ring& ring = rings_[p.ring];
    ring.elevations += static_cast<double>(elevation_of(p));
    ring.count += 1;
    if (column == nullptr) continue;
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
    for (std::size_t i = first; i < cloud.size(); i += step) add(cloud, i, i + 1, nullptr);
  } else {
    for (std::size_t c = first; c < cloud.columns.size(); c += step) {
      add(cloud, cloud.columns[c].first_point, cloud.points_end(c), &cloud.columns[c]);
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
    if (!shows_direction(p)) continue;
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
    // A ring is narrow and has more than stray returns.
    if (end - begin <= 6 && count * 1000 > all) {
      elevations.push_back(sum / static_cast<float>(count) * width - static_cast<float>(pi_d / 2));
      in_groups += count;
    }
    begin = end + 1;
  }
  if (elevations.size() < 2 || elevations.size() > most_rings || in_groups * 10 < all * 9) elevations.clear();
}

namespace {

constexpr float turn = static_cast<float>(two_pi);
constexpr std::size_t fewest_steps = 8;
// Smaller steps are between returns of one firing, larger ones between turns.
constexpr float shortest_step = 3e-4F;
constexpr float longest_step = 0.05F;
constexpr std::size_t most_columns = 20000;

std::uint16_t nearest_ring(const std::vector<float>& elevations, const CloudPoint& p) {
  const float elevation = elevation_of(p);
  std::size_t best = 0;
  for (std::size_t r = 1; r < elevations.size(); ++r) {
    if (std::fabs(elevations[r] - elevation) < std::fabs(elevations[best] - elevation)) best = r;
  }
  return static_cast<std::uint16_t>(best);
}

}  // namespace

/// Fills rows_: the row of each ring number, in order of elevation on the vehicle.
bool RingGrid::number_rings(const Cloud& cloud) {
  if (cloud.rings > 1) {
    found_.clear();
    table_.set_rings(cloud);
    table_.learn(cloud, false);
    rings_ = cloud.rings;
    elevations_.resize(rings_);
    known_.resize(rings_);
    rows_.resize(rings_);
    for (std::size_t r = 0; r < rings_; ++r) {
      std::size_t row = 0;
      for (std::size_t other = 0; other < rings_; ++other) {
        const double mine = table_.is_known(r) ? table_.elevation(r) : 10;
        const double its = table_.is_known(other) ? table_.elevation(other) : 10;
        if (its < mine || (its == mine && other < r)) ++row;
      }
      row = row_of(row);
      rows_[r] = static_cast<std::uint16_t>(row);
      elevations_[row] = table_.elevation(r);
      known_[row] = table_.is_known(r) ? 1 : 0;
    }
    return true;
  }
  if (found_.empty()) find_rings(cloud, found_);
  rings_ = found_.size();
  elevations_.assign(found_.begin(), found_.end());
  if (hangs_) std::reverse(elevations_.begin(), elevations_.end());
  known_.assign(rings_, 1);
  return rings_ > 1;
}

/// Measures the azimuth step of the coarsest ring; finer rings then have several returns per column.
bool RingGrid::measure_step(const Cloud& cloud) {
  steps_.resize(rings_);
  for (auto& azimuths : steps_) azimuths.clear();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (point_rows_[i] < rings_) steps_[point_rows_[i]].push_back(point_azimuths_[i]);
  }
  for (auto& steps : steps_) {
    // Other drivers' points may come in any order.
    std::sort(steps.begin(), steps.end());
    std::adjacent_difference(steps.begin(), steps.end(), steps.begin());
    if (!steps.empty()) steps.front() = 0;
    const auto is_none = [](float step) { return !(step > shortest_step && step < longest_step); };
    steps.erase(std::remove_if(steps.begin(), steps.end(), is_none), steps.end());
  }
  float coarsest = 0;
  std::size_t most = 0;
  for (const auto& steps : steps_) most = std::max(most, steps.size());
  for (auto& steps : steps_) {
    // A ring with few returns shows gaps instead of steps.
    if (steps.size() < std::max(fewest_steps, most / 16)) continue;
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    // The mean of the usual steps, since single steps are rounded on the wire.
    const float limit = *middle * 1.3F;
    float sum = 0;
    float count = 0;
    for (const float step : steps) {
      if (step > limit || step < *middle * 0.7F) continue;
      sum += step;
      count += 1;
    }
    // The gaps of a ring that hits leaves differ.
    if (2 * count > static_cast<float>(steps.size())) coarsest = std::max(coarsest, sum / count);
  }
  if (!(coarsest > 0)) return false;
  const auto step = static_cast<double>(turn / std::round(turn / coarsest));
  constexpr double noise = 0.05;
  if (std::fabs(step - step_) > noise * step_) step_ = step;
  return true;
}

/// Measures per ring the circular mean of the returns' positions within a column's width.
void RingGrid::measure_phases(const Cloud& cloud) {
  phases_.assign(rings_, 0);
  phase_sines_.assign(rings_, 0);
  const auto per_rad = static_cast<float>(1 / step_);
  constexpr std::size_t every = 7;
  for (std::size_t i = 0; i < cloud.size(); i += every) {
    if (point_rows_[i] >= rings_) continue;
    const float angle = turn * point_azimuths_[i] * per_rad;
    phases_[point_rows_[i]] += std::cos(angle);
    phase_sines_[point_rows_[i]] += std::sin(angle);
  }
  for (std::size_t r = 0; r < rings_; ++r) phases_[r] = fast_atan2(phase_sines_[r], phases_[r]) / turn;
}

void RingGrid::fill_points(const Cloud& cloud, const CloudMotion* motion) {
  const auto per_rad = static_cast<float>(1 / step_);
  const auto columns = static_cast<std::size_t>(std::lround(static_cast<double>(turn) / step_));
  clear_grid(columns, rings_);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::size_t row = point_rows_[i];
    if (row >= rings_) {
      ++outside;
      continue;
    }
    const float at = std::round(point_azimuths_[i] * per_rad - phases_[row]);
    auto column = static_cast<std::size_t>(at < 0 ? at + static_cast<float>(columns) : at);
    if (column >= columns) column -= columns;
    fired_[column] = 1;
    azimuths_[column] = static_cast<float>(column) * static_cast<float>(step_) - turn / 2;
    const CloudPoint& point = cloud.points()[i];
    times_[column] = point.time;
    const Pose move = motion != nullptr ? motion->at(static_cast<double>(point.time)) : Pose::Identity();
    put(index(column, row), point, motion != nullptr ? &move : nullptr);
  }
}

/// Marks missing beams of a column that has returns as `none`.
void RingGrid::open_gaps() {
  for (std::size_t c = 0; c < columns_; ++c) {
    if (fired_[c] == 0) continue;
    for (std::size_t r = 0; r < rings_; ++r) {
      Beam& beam = kind[index(c, r)];
      if (beam == Beam::unknown && known_[r] != 0) beam = Beam::none;
    }
  }
}

bool RingGrid::organise_points(const Cloud& cloud, const CloudMotion* motion) {
  if (!number_rings(cloud)) {
    why_not_ = "its returns do not fall into rings";
    return false;
  }
  point_azimuths_.resize(cloud.size());
  point_rows_.resize(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const CloudPoint& p = cloud.points()[i];
    point_azimuths_[i] = fast_atan2(-p.y, p.x) + turn / 2;
    const bool finite = std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
    if (!finite)
      point_rows_[i] = 0xFFFF;
    else if (!found_.empty())
      point_rows_[i] = static_cast<std::uint16_t>(row_of(nearest_ring(found_, p)));
    else
      point_rows_[i] = p.ring < rings_ ? rows_[p.ring] : std::uint16_t{0xFFFF};
  }
  // The device may be set to other steps while it runs.
  constexpr std::size_t measured_every = 50;
  const bool is_new = step_ <= 0 || measured_rings_ != rings_;
  if ((is_new || ++clouds_ % measured_every == 0) && !measure_step(cloud) && is_new) {
    why_not_ = "its rings have too few returns to measure their azimuth step";
    return false;
  }
  measured_rings_ = rings_;
  const auto columns = static_cast<std::size_t>(std::lround(static_cast<double>(turn) / step_));
  if (columns < fewest_steps || columns > most_columns) {
    why_not_ = "its returns' azimuth step is not that of a lidar";
    return false;
  }
  measure_phases(cloud);
  fill_points(cloud, motion);
  open_gaps();
  fill_without_return(cloud, motion);
  bridge_single_gaps();
  return true;
}

}  // namespace lidard
