// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/ring_grid.h"

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/base/bytes.h"

namespace lidard {
namespace {

// A step of more than this number of usual steps spans missing columns.
constexpr double gap_steps = 1.6;
constexpr std::size_t fewest_columns = 8;
constexpr std::uint32_t nowhere = 0xFFFFFFFFU;

// Stands for the step between two returns of one firing.
constexpr double no_step = -two_pi;

double mean_step(const std::vector<double>& steps, double limit) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t c = 1; c < steps.size(); ++c) {
    if (steps[c] > limit || steps[c] == no_step) continue;
    sum += steps[c];
    ++count;
  }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

void move_end(BeamEnd& end, const Pose& move) {
  const Eigen::Vector3d moved = move * Eigen::Vector3d(static_cast<double>(end.x), static_cast<double>(end.y),
                                                       static_cast<double>(end.z));
  end.x = static_cast<float>(moved.x());
  end.y = static_cast<float>(moved.y());
  end.z = static_cast<float>(moved.z());
}

float length(const BeamEnd& end) { return std::sqrt(end.x * end.x + end.y * end.y + end.z * end.z); }

}  // namespace

void RingGrid::set_footprint(const Footprint& own, const Pose& vehicle_from_cloud) {
  own_ = own;
  vehicle_from_cloud_ = vehicle_from_cloud;
  hangs_ = vehicle_from_cloud.linear()(2, 2) < 0;
  double reach = 0;
  const Eigen::Vector2d origin = vehicle_from_cloud.translation().head<2>();
  for (const auto& corner : own.vertices()) reach = std::max(reach, (corner - origin).norm());
  own_reach_ = static_cast<float>(reach);
}

bool RingGrid::organise(const Cloud& cloud, const CloudMotion* motion) {
  early.clear();
  why_not_ = "";
  if (motion != nullptr && motion->stands()) motion = nullptr;
  moved = motion != nullptr;
  by_azimuth_ = !fires_in_columns(cloud);
  if (by_azimuth_ && !organise_points(cloud, motion)) return false;
  if (!by_azimuth_) organise_columns(cloud, motion);
  if (motion != nullptr) find_origins(*motion);
  return true;
}

void RingGrid::find_origins(const CloudMotion& motion) {
  origins.resize(columns_);
  for (std::size_t c = 0; c < columns_; ++c) {
    const Eigen::Vector3f at = motion.at(static_cast<double>(times_[c])).translation().cast<float>();
    origins[c] = {at.x(), at.y(), at.z(), 0};
  }
}

bool RingGrid::fires_in_columns(const Cloud& cloud) {
  if (cloud.columns.size() < fewest_columns || cloud.rings < 2 || cloud.bank_by_bank) return false;
  turns_.resize(cloud.columns.size());
  turns_[0] = 0;
  double turned = 0;
  for (std::size_t c = 1; c < cloud.columns.size(); ++c) {
    const bool again = same_firing(cloud.columns[c - 1], cloud.columns[c]);
    turns_[c] = again ? no_step : azimuth_step(cloud.columns[c - 1], cloud.columns[c]);
    turned += again ? 0 : turns_[c];
    if (turned > 1.2 * two_pi) return false;
  }
  // Repeated with tighter limits, so that hidden sectors and lost packets do not count.
  step_ = mean_step(turns_, two_pi);
  step_ = mean_step(turns_, 2.5 * step_);
  step_ = mean_step(turns_, gap_steps * step_);
  return step_ > 1e-4;
}

void RingGrid::clear_grid(std::size_t columns, std::size_t rings) {
  columns_ = columns;
  rings_ = rings;
  resize_amply(columns * rings, ends, range, kind);
  resize_amply(columns, fired_, azimuths_, times_);
  std::fill(kind.begin(), kind.end(), Beam::unknown);
  std::fill(fired_.begin(), fired_.end(), char{0});
  std::fill(azimuths_.begin(), azimuths_.end(), 0.0F);
  std::fill(times_.begin(), times_.end(), 0.0F);
}

void RingGrid::number_columns(const Cloud& cloud, std::size_t lead) {
  to_columns_.resize(cloud.columns.size());
  double turned = 0;
  std::size_t to_column = 0;
  std::size_t beyond = 0;
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    if (c > 0 && turns_[c] != no_step) {
      const double step = turns_[c];
      const bool closed = turned + step > two_pi - step_ / 2;
      if (closed || beyond > 0) {
        ++beyond;
      } else {
        turned += step;
        to_column += step > 1.5 * step_ ? static_cast<std::size_t>(std::lround(step / step_)) : 1;
      }
    }
    to_columns_[c] = beyond > 0 ? nowhere : static_cast<std::uint32_t>(lead + to_column);
  }
  outside += beyond;
  const long rest = std::max(1L, std::lround((two_pi - turned) / step_));
  clear_grid(lead + to_column + static_cast<std::size_t>(rest), cloud.rings);
}

void RingGrid::open_column(std::size_t column, double azimuth) {
  fired_[column] = 1;
  azimuths_[column] = static_cast<float>(azimuth);
  if (straight_) {
    std::fill_n(kind.begin() + static_cast<std::ptrdiff_t>(index(column, 0)), rings_, Beam::none);
    return;
  }
  for (std::size_t r = 0; r < rings_; ++r) {
    if (known_[r] == 0 || (lead_ > 0 && goes_round(column, r))) continue;
    std::size_t to = column + shifts_[r];
    to -= to >= columns_ ? columns_ : 0;
    kind[index(to, r)] = Beam::none;
  }
}

void RingGrid::organise_columns(const Cloud& cloud, const CloudMotion* motion) {
  table_.set_rings(cloud);
  table_.learn(cloud, true);
  lead_ = motion != nullptr ? lead(cloud, *motion) : 0;
  number_columns(cloud, lead_);
  number_shifts();
  if (motion != nullptr && lead_ > 0) {
    // Times count from this cloud's stamp.
    tail_.stamp = cloud.stamp;
    fill_lead(lead_, *motion);
  }
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    if (to_columns_[c] == nowhere) continue;
    if (fired_[to_columns_[c]] == 0)
      open_column(to_columns_[c], static_cast<double>(cloud.columns[c].azimuth));
    times_[to_columns_[c]] = static_cast<float>(seconds(cloud.columns[c].stamp - cloud.stamp));
    fill_column(cloud, c, to_columns_[c], motion != nullptr ? &motion->columns()[c] : nullptr);
  }
  if (!moved) measure_ranges();
  extend_azimuths();
  for (const NearReturn& near : cloud.too_near) {
    if (near.column < to_columns_.size() && to_columns_[near.column] != nowhere)
      mark_too_near(near, to_columns_[near.column]);
  }
  fill_without_return(cloud, motion);
  bridge_single_gaps();
  keep_tail(cloud);
}

void RingGrid::number_shifts() {
  shifts_.resize(rings_);
  offsets_.resize(rings_);
  elevations_.resize(rings_);
  known_.resize(rings_);
  straight_ = true;
  const auto columns = static_cast<long>(columns_);
  for (std::size_t r = 0; r < rings_; ++r) {
    const long shift = std::lround(table_.offset(r) / step_) % columns;
    const std::size_t row = row_of(r);
    shifts_[row] = static_cast<std::uint32_t>(shift < 0 ? shift + columns : shift);
    offsets_[r] = index(shifts_[row], row);
    elevations_[row] = table_.elevation(r);
    known_[row] = table_.is_known(r) ? 1 : 0;
    straight_ = straight_ && shift == 0 && known_[row] != 0;
  }
}

/// Beams with an offset of azimuth lie in columns that were not fired, in gaps of any width.
void RingGrid::extend_azimuths() {
  for (std::size_t c = 1; c < columns_; ++c) {
    if (fired_[c] != 0) continue;
    azimuths_[c] = azimuths_[c - 1] + static_cast<float>(step_);
    times_[c] = times_[c - 1];
  }
}

void RingGrid::fill_column(const Cloud& cloud, std::size_t column, std::size_t to_column, const Pose* move) {
  const std::size_t end = cloud.points_end(column);
  const std::size_t first = index(to_column, 0);
  const std::size_t cells = kind.size();
  // Local copies: the compiler must assume that the bytes of points alias the members.
  const std::size_t rings = rings_;
  const std::size_t* const offsets = offsets_.data();
  const CloudPoint* const points = cloud.points();
  Beam* const kinds = kind.data();
  BeamEnd* const to = ends.data();
  for (std::size_t i = cloud.columns[column].first_point; i < end; ++i) {
    const CloudPoint& point = points[i];
    const std::size_t ring = point.ring;
    if (ring >= rings || (lead_ > 0 && goes_round(to_column, row_of(ring)))) continue;
    std::size_t at = first + offsets[ring];
    at -= at >= cells ? cells : 0;
    if (move == nullptr && kinds[at] != Beam::point) {
      to[at] = {point.x, point.y, point.z, point.intensity};
      kinds[at] = Beam::point;
    } else {
      if (move == nullptr) check(at);
      put(at, point, move);
    }
  }
}

/// Computes the ranges of a cloud at rest and checks its returns.
void RingGrid::measure_ranges() {
  const std::size_t cells = ends.size();
  const BeamEnd* const from = ends.data();
  float* const to = range.data();
  for (std::size_t i = 0; i < cells; ++i)
    to[i] = std::sqrt(from[i].x * from[i].x + from[i].y * from[i].y + from[i].z * from[i].z);
  constexpr float infinite = std::numeric_limits<float>::infinity();
  const float reach = own_reach_;
  for (std::size_t c = 0; c < columns_; ++c) {
    const float* const column = to + index(c, 0);
    int usual = 1;
    for (std::size_t r = 0; r < rings_; ++r)
      usual &= (column[r] >= reach ? 1 : 0) & (column[r] < infinite ? 1 : 0);
    if (usual != 0) continue;
    for (std::size_t i = index(c, 0); i < index(c, rings_); ++i) {
      if (kind[i] == Beam::point) check(i);
    }
  }
}

/// Drops a return that hit the vehicle or is not finite.
void RingGrid::check(std::size_t at) {
  range[at] = length(ends[at]);
  if (!std::isfinite(range[at])) {
    kind[at] = Beam::none;
  } else if (range[at] < own_reach_ && is_own(ends[at])) {
    ++own_returns;
    kind[at] = Beam::own;
  }
}

void RingGrid::mark_too_near(const NearReturn& near, std::size_t to_column) {
  if (near.ring >= rings_ || (lead_ > 0 && goes_round(to_column, row_of(near.ring)))) return;
  const std::size_t to = (index(to_column, 0) + offsets_[near.ring]) % kind.size();
  if (kind[to] != Beam::point) kind[to] = Beam::own;
}

bool RingGrid::is_own(const BeamEnd& end) const {
  const Eigen::Vector3d p(static_cast<double>(end.x), static_cast<double>(end.y), static_cast<double>(end.z));
  return own_.contains((vehicle_from_cloud_ * p).head<2>());
}

void RingGrid::put(std::size_t at, const CloudPoint& point, const Pose* move) {
  BeamEnd end{point.x, point.y, point.z, point.intensity};
  const float far = length(end);
  if (!std::isfinite(far)) return;
  if (far < own_reach_ && is_own(end)) {
    ++own_returns;
    if (kind[at] != Beam::point) kind[at] = Beam::own;
    return;
  }
  // The last return of a firing is the surface. Without firings the returns may be two beams of a fine ring;
  // then the nearer one counts.
  const bool again = kind[at] == Beam::point;
  const bool is_nearer = again && far < range[at];
  if (move != nullptr) move_end(end, *move);
  if (again && settings_.early_returns) early.push_back(is_nearer ? end : ends[at]);
  if (again && is_nearer != by_azimuth_) return;
  kind[at] = Beam::point;
  range[at] = far;
  ends[at] = end;
}

void RingGrid::fill_without_return(const Cloud& cloud, const CloudMotion* motion) {
  const double wanted = settings_.no_return_free_range;
  const double reach = cloud.max_range > 0 ? std::min(wanted, cloud.max_range) : wanted;
  level_.resize(rings_);
  rise_.resize(rings_);
  for (std::size_t r = 0; r < rings_; ++r) {
    level_[r] = static_cast<float>(reach * std::cos(elevations_[r]));
    rise_[r] = static_cast<float>(reach * std::sin(elevations_[r]));
  }
  for (std::size_t c = 0; c < columns_; ++c) {
    Beam* const beams = kind.data() + index(c, 0);
    if (!holds(beams, rings_, static_cast<std::uint8_t>(Beam::none))) continue;
    float cosine = 0;
    float sine = 0;
    Pose move = Pose::Identity();
    bool ready = false;
    for (std::size_t r = 0; r < rings_; ++r) {
      if (beams[r] != Beam::none) continue;
      if (!(reach > 0)) {
        beams[r] = Beam::unknown;
        continue;
      }
      if (!ready) {
        cosine = std::cos(azimuths_[c]);
        sine = -std::sin(azimuths_[c]);
        if (motion != nullptr) move = motion->at(static_cast<double>(times_[c]));
        ready = true;
      }
      const std::size_t at = index(c, r);
      ends[at] = {level_[r] * cosine, level_[r] * sine, rise_[r], 0};
      range[at] = static_cast<float>(reach);
      if (motion != nullptr) move_end(ends[at], move);
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

/// Interpolates a single missing beam between two neighbours of the same kind.
void RingGrid::bridge(std::size_t before, std::size_t at, std::size_t after) {
  if (kind[before] != kind[after] || (kind[at] == Beam::none && kind[before] == Beam::none)) return;
  if (kind[before] != Beam::point && kind[before] != Beam::none) return;
  // The limit of a surface at 18 degrees to the beam.
  const float near = std::min(range[before], range[after]);
  const auto limit = static_cast<float>(3 * 2 * step_) * near + 0.06F;
  if (std::fabs(range[before] - range[after]) > limit) return;
  kind[at] = kind[before];
  const BeamEnd& a = ends[before];
  const BeamEnd& b = ends[after];
  ends[at] = {(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2, (a.intensity + b.intensity) / 2};
  range[at] = (range[before] + range[after]) / 2;
}

}  // namespace lidard
