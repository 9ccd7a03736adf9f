// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/ring_grid.h"

#include <algorithm>
#include <cmath>

#include "core/angle.h"

namespace lidard {
namespace {

constexpr double turn = 2 * pi_d;
// The motor's jitter; a larger step backwards is nearly a whole turn forwards.
constexpr double backwards_limit = 0.02;
// A larger step than so many usual ones has unseen columns in between.
constexpr double gap_steps = 1.6;
constexpr std::size_t fewest_columns = 8;
constexpr std::uint32_t nowhere = 0xFFFFFFFFU;

double step_between(double from, double to) {
  double step = to - from;
  while (step < 0) step += turn;
  while (step >= turn) step -= turn;
  return step > turn - backwards_limit ? step - turn : step;
}

double step_between(const CloudColumn& a, const CloudColumn& b) {
  return step_between(static_cast<double>(a.azimuth), static_cast<double>(b.azimuth));
}

/// Two returns of one firing.
bool same_firing(const CloudColumn& a, const CloudColumn& b) {
  return a.echo != b.echo && a.stamp == b.stamp && a.azimuth == b.azimuth;
}

double mean_step(const std::vector<CloudColumn>& columns, double limit) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t c = 1; c < columns.size(); ++c) {
    const double step = step_between(columns[c - 1], columns[c]);
    if (step > limit || same_firing(columns[c - 1], columns[c])) continue;
    sum += step;
    ++count;
  }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

}  // namespace

void RingGrid::set_footprint(const Footprint& own, const Pose& vehicle_from_cloud) {
  own_ = own;
  vehicle_from_cloud_ = vehicle_from_cloud;
  double reach = 0;
  const Eigen::Vector2d origin = vehicle_from_cloud.translation().head<2>();
  for (const auto& corner : own.vertices()) reach = std::max(reach, (corner - origin).norm());
  own_reach_ = static_cast<float>(reach);
}

bool RingGrid::organise(const Cloud& cloud, const std::vector<Pose>& columns_to_now) {
  early.clear();
  why_not_ = "";
  by_azimuth_ = !fires_in_columns(cloud);
  if (!by_azimuth_) {
    organise_columns(cloud, columns_to_now);
    return true;
  }
  return organise_points(cloud);
}

bool RingGrid::fires_in_columns(const Cloud& cloud) {
  if (cloud.columns.size() < fewest_columns || cloud.rings < 2) return false;
  double turned = 0;
  for (std::size_t c = 1; c < cloud.columns.size(); ++c) {
    turned += step_between(cloud.columns[c - 1], cloud.columns[c]);
    if (turned > 1.2 * turn) return false;
  }
  // Again, so that neither a hidden sector nor lost packets count as the usual step.
  step_ = mean_step(cloud.columns, turn);
  step_ = mean_step(cloud.columns, 2.5 * step_);
  step_ = mean_step(cloud.columns, gap_steps * step_);
  return step_ > 1e-4;
}

void RingGrid::clear_grid(std::size_t columns, std::size_t rings) {
  columns_ = columns;
  rings_ = rings;
  const std::size_t cells = columns * rings;
  // The number of columns varies a little from turn to turn.
  const std::size_t room = cells + cells / 16;
  for (auto* list : {&x, &y, &z, &range, &intensity}) {
    if (list->capacity() < cells) list->reserve(room);
    list->resize(cells);
  }
  if (kind.capacity() < cells) {
    kind.reserve(room);
    fired_.reserve(room / rings);
    azimuths_.reserve(room / rings);
    sources_.reserve(room / rings);
  }
  kind.assign(cells, Beam::unknown);
  fired_.assign(columns, 0);
  azimuths_.assign(columns, 0);
  sources_.assign(columns, 0);
}

void RingGrid::number_columns(const Cloud& cloud) {
  places_.resize(cloud.columns.size());
  double turned = 0;
  std::size_t place = 0;
  std::size_t beyond = 0;
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    if (c > 0 && !same_firing(cloud.columns[c - 1], cloud.columns[c])) {
      const double step = step_between(cloud.columns[c - 1], cloud.columns[c]);
      const bool closed = turned + step > turn - step_ / 2;
      if (closed || beyond > 0) {
        ++beyond;
      } else {
        turned += step;
        place += static_cast<std::size_t>(std::max(1L, std::lround(step / step_)));
      }
    }
    places_[c] = beyond > 0 ? nowhere : static_cast<std::uint32_t>(place);
  }
  misplaced += beyond;
  const long rest = std::max(1L, std::lround((turn - turned) / step_));
  clear_grid(place + static_cast<std::size_t>(rest), cloud.rings);
}

void RingGrid::open_column(std::size_t column, double azimuth) {
  fired_[column] = 1;
  azimuths_[column] = static_cast<float>(azimuth);
  for (std::size_t r = 0; r < rings_; ++r) {
    if (known_[r] == 0) continue;
    std::size_t to = column + shifts_[r];
    to -= to >= columns_ ? columns_ : 0;
    kind[index(to, r)] = Beam::none;
  }
}

void RingGrid::organise_columns(const Cloud& cloud, const std::vector<Pose>& columns_to_now) {
  table_.set_rings(cloud.rings);
  table_.learn(cloud, true);
  number_columns(cloud);
  shifts_.resize(rings_);
  elevations_.resize(rings_);
  known_.resize(rings_);
  const auto columns = static_cast<long>(columns_);
  for (std::size_t r = 0; r < rings_; ++r) {
    const long shift = std::lround(table_.offset(r) / step_) % columns;
    shifts_[r] = static_cast<std::uint32_t>(shift < 0 ? shift + columns : shift);
    elevations_[r] = table_.elevation(r);
    known_[r] = table_.is_known(r) ? 1 : 0;
  }
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    const std::size_t place = places_[c];
    if (place == nowhere) continue;
    if (fired_[place] == 0) open_column(place, static_cast<double>(cloud.columns[c].azimuth));
    sources_[place] = static_cast<std::uint32_t>(c);
    const std::size_t end = c + 1 < cloud.columns.size() ? cloud.columns[c + 1].first_point : cloud.size();
    const Pose* move = columns_to_now.empty() ? nullptr : &columns_to_now[c];
    for (std::size_t i = cloud.columns[c].first_point; i < end; ++i) {
      const CloudPoint& point = cloud.points()[i];
      if (point.ring >= rings_) continue;
      std::size_t to = place + shifts_[point.ring];
      to -= to >= columns_ ? columns_ : 0;
      put(index(to, point.ring), point, move);
    }
  }
  mark_too_near(cloud);
  place_without_return(columns_to_now);
  bridge_single_gaps();
}

void RingGrid::mark_too_near(const Cloud& cloud) {
  for (const NearReturn& near : cloud.too_near) {
    if (near.column >= places_.size() || places_[near.column] == nowhere || near.ring >= rings_) continue;
    const std::size_t to = (places_[near.column] + shifts_[near.ring]) % columns_;
    if (kind[index(to, near.ring)] != Beam::point) kind[index(to, near.ring)] = Beam::own;
  }
}

bool RingGrid::is_own(const CloudPoint& point, float range_m) const {
  if (!(range_m < own_reach_)) return false;
  const Eigen::Vector3d p(static_cast<double>(point.x), static_cast<double>(point.y),
                          static_cast<double>(point.z));
  return own_.contains((vehicle_from_cloud_ * p).head<2>());
}

void RingGrid::put(std::size_t at, const CloudPoint& point, const Pose* move) {
  const float far = std::sqrt(point.x * point.x + point.y * point.y + point.z * point.z);
  if (!std::isfinite(far)) return;
  if (is_own(point, far)) {
    ++own_returns;
    if (kind[at] != Beam::point) kind[at] = Beam::own;
    return;
  }
  // Of several returns of a firing the last one is the surface; those before it are seen through. Where
  // firings are not known, it may be two beams of a fine ring: the nearer one hides.
  const bool again = kind[at] == Beam::point;
  const bool is_nearer = again && far < range[at];
  if (again && settings_.early_returns)
    early.push_back(is_nearer ? point : CloudPoint{x[at], y[at], z[at], intensity[at], 0, 0});
  if (again && is_nearer != by_azimuth_) return;
  kind[at] = Beam::point;
  range[at] = far;
  intensity[at] = point.intensity;
  if (move == nullptr) {
    x[at] = point.x;
    y[at] = point.y;
    z[at] = point.z;
    return;
  }
  const Eigen::Vector3d moved =
      *move * Eigen::Vector3d(static_cast<double>(point.x), static_cast<double>(point.y),
                              static_cast<double>(point.z));
  x[at] = static_cast<float>(moved.x());
  y[at] = static_cast<float>(moved.y());
  z[at] = static_cast<float>(moved.z());
}

void RingGrid::place_without_return(const std::vector<Pose>& columns_to_now) {
  const double reach = settings_.no_return_free_range;
  level_.resize(rings_);
  rise_.resize(rings_);
  for (std::size_t r = 0; r < rings_; ++r) {
    level_[r] = static_cast<float>(reach * std::cos(elevations_[r]));
    rise_[r] = static_cast<float>(reach * std::sin(elevations_[r]));
  }
  for (std::size_t c = 0; c < columns_; ++c) {
    Beam* const beams = kind.data() + index(c, 0);
    float cosine = 0;
    float sine = 0;
    bool ready = false;
    for (std::size_t r = 0; r < rings_; ++r) {
      if (beams[r] != Beam::none) continue;
      if (!(reach > 0)) {
        beams[r] = Beam::unknown;
        continue;
      }
      if (!ready) {
        // A column that was not fired has beams of its neighbours'.
        const std::size_t from = fired_[c] != 0 || c == 0 ? c : c - 1;
        const float azimuth = azimuths_[from] + (from == c ? 0 : static_cast<float>(step_));
        cosine = std::cos(azimuth);
        sine = -std::sin(azimuth);
        ready = true;
      }
      const std::size_t at = index(c, r);
      x[at] = level_[r] * cosine;
      y[at] = level_[r] * sine;
      z[at] = rise_[r];
      range[at] = static_cast<float>(reach);
      if (columns_to_now.empty()) continue;
      const Eigen::Vector3d moved =
          columns_to_now[sources_[c]] *
          Eigen::Vector3d(static_cast<double>(x[at]), static_cast<double>(y[at]), static_cast<double>(z[at]));
      x[at] = static_cast<float>(moved.x());
      y[at] = static_cast<float>(moved.y());
      z[at] = static_cast<float>(moved.z());
    }
  }
}

void RingGrid::bridge_single_gaps() {
  const bool complete = std::all_of(fired_.begin(), fired_.end(), [](char fired) { return fired != 0; });
  if (complete && !by_azimuth_) return;
  for (std::size_t c = 0; c < columns_; ++c) {
    const std::size_t before = c > 0 ? c - 1 : columns_ - 1;
    const std::size_t next = after(c);
    const Beam gap = by_azimuth_ ? Beam::none : Beam::unknown;
    for (std::size_t r = 0; r < rings_; ++r) {
      const Beam here = kind[index(c, r)];
      if (here == Beam::unknown || here == gap) bridge(index(before, r), index(c, r), index(next, r));
    }
  }
}

/// A single missing beam between two of the same kind is taken to lie in the middle between them.
void RingGrid::bridge(std::size_t before, std::size_t at, std::size_t after) {
  if (kind[before] != kind[after] || (kind[at] == Beam::none && kind[before] == Beam::none)) return;
  if (kind[before] != Beam::point && kind[before] != Beam::none) return;
  // A surface that need not be steeper than 18 degrees against the beam.
  const float near = std::min(range[before], range[after]);
  const auto limit = static_cast<float>(3 * 2 * step_) * near + 0.06F;
  if (std::fabs(range[before] - range[after]) > limit) return;
  kind[at] = kind[before];
  x[at] = (x[before] + x[after]) / 2;
  y[at] = (y[before] + y[after]) / 2;
  z[at] = (z[before] + z[after]) / 2;
  range[at] = (range[before] + range[after]) / 2;
  intensity[at] = (intensity[before] + intensity[after]) / 2;
}

}  // namespace lidard
