// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The part of RingGrid that closes the turn of a lidar on a vehicle that turns.
#include <algorithm>
#include <cmath>

#include "core/virtual/ring_grid.h"

namespace lidard {
namespace {

constexpr double most_lead = 0.35;  // rad; at 10 Hz a vehicle that turns with 3.5 rad/s

}  // namespace

/// A revolution of a lidar on a vehicle that turns with it leaves a wedge open: it is a full turn over the
/// lidar, not over the ground. The last columns of the revolution before close the wedge, and come before the
/// first column. Returns their number.
std::size_t RingGrid::lead(const Cloud& cloud, const CloudMotion& motion) const {
  if (tail_.columns.empty() || tail_.rings != cloud.rings) return 0;
  const CloudColumn &last = tail_.columns.back(), &first = cloud.columns.front();
  const Span between =
      (cloud.columns.back().stamp - first.stamp) / static_cast<std::int64_t>(cloud.columns.size());
  const double step = azimuth_step(last, first);
  if (!(step > 0 && step < 2.5 * step_) || first.stamp < last.stamp || first.stamp - last.stamp > 5 * between)
    return 0;
  const Pose turned = motion.at(0) * motion.at(seconds(cloud.end - cloud.stamp)).inverse();
  const double wedge = std::fabs(std::atan2(turned.linear()(1, 0), turned.linear()(0, 0)));
  constexpr double slack = 0.01;  // rad, of a vehicle that drives
  return static_cast<std::size_t>(std::min(wedge + slack, most_lead) / step_);
}

void RingGrid::fill_lead(std::size_t lead, const CloudMotion& motion) {
  const Pose move = motion.at(0);
  const std::uint64_t own = own_returns;  // they were counted
  std::vector<std::size_t>& to_columns = tail_to_columns_;
  to_columns.assign(tail_.columns.size(), columns_);
  double turned = step_ / 2;
  for (std::size_t c = tail_.columns.size(); c-- > 0;) {
    const CloudColumn& column = tail_.columns[c];
    if (c + 1 < tail_.columns.size() && !same_firing(column, tail_.columns[c + 1]))
      turned += azimuth_step(column, tail_.columns[c + 1]);
    const auto back = static_cast<std::size_t>(turned / step_);
    if (back >= lead) continue;
    to_columns[c] = lead - 1 - back;
    if (fired_[to_columns[c]] == 0) open_column(to_columns[c], static_cast<double>(column.azimuth));
  }
  for (std::size_t c = 0; c < to_columns.size(); ++c) {
    if (to_columns[c] == columns_) continue;
    times_[to_columns[c]] = static_cast<float>(seconds(tail_.columns[c].stamp - tail_.stamp));
    fill_column(tail_, c, to_columns[c], &move);
  }
  for (const NearReturn& near : tail_.too_near) {
    if (to_columns[near.column] != columns_) mark_too_near(near, to_columns[near.column]);
  }
  own_returns = own;
}

/// Keeps the last columns of a cloud for the next one.
void RingGrid::keep_tail(const Cloud& cloud) {
  tail_.clear();
  tail_.rings = cloud.rings;
  std::size_t first = cloud.columns.size();
  for (double turned = 0; first > 0 && turned < most_lead; --first)
    turned += std::max(turns_[first - 1], 0.0);
  if (first == cloud.columns.size()) return;
  const std::uint32_t point = cloud.columns[first].first_point;
  tail_.points_bytes.assign(
      cloud.points_bytes.begin() + static_cast<std::ptrdiff_t>(point * sizeof(CloudPoint)),
      cloud.points_bytes.end());
  tail_.columns.assign(cloud.columns.begin() + static_cast<std::ptrdiff_t>(first), cloud.columns.end());
  for (CloudColumn& column : tail_.columns) column.first_point -= point;
  for (NearReturn near : cloud.too_near) {
    if (near.column < first) continue;
    near.column -= static_cast<std::uint32_t>(first);
    tail_.too_near.push_back(near);
  }
}

/// True if a row's beam that points ahead of its column, or behind it, would lie beyond the last column or
/// before the first one. Only a full turn goes on there.
bool RingGrid::goes_round(std::size_t column, std::size_t row) const {
  const bool behind = shifts_[row] > columns_ / 2;
  return behind != (column + shifts_[row] >= columns_);
}

}  // namespace lidard
