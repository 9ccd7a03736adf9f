// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/ring_scan.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

constexpr double turn = two_pi;
/// Neighbours farther apart than this many firing steps have something unseen between them.
constexpr double gap_steps = 1.6;
/// A firing is valid this far beyond itself where its neighbour is missing and at the ends of a revolution.
constexpr double reach_steps = 0.6;
constexpr double reach_steps_at_ends = 1.1;
/// Change of range per rad and range: a surface seen under more than atan(1 / 3) = 18 deg.
constexpr double steepest = 3;
/// Nearer returns are too close to the sensor's optics to show the direction of the beam.
constexpr double direction_range_m = 1;

/// The point of `ring` in a column, or nullptr.
const CloudPoint* point_in_column(const Cloud& cloud, std::size_t column, std::uint16_t ring) {
  for (std::size_t i = cloud.columns[column].first_point; i < cloud.points_end(column); ++i) {
    if (cloud.points()[i].ring == ring) return cloud.points() + i;
  }
  return nullptr;
}

}  // namespace

RingScan::RingScan(const RingScanSpec& spec)
    : spec_(spec),
      beams_(static_cast<std::size_t>(std::max(1L, std::lround(turn / spec.resolution)))),
      increment_(turn / static_cast<double>(beams_)) {}

void RingScan::set_ranges(double range_min, double range_max) {
  spec_.range_min = range_min;
  spec_.range_max = range_max;
}

void RingScan::gather(const Cloud& cloud) {
  firings_.clear();
  double position = 0;
  double offsets = 0;
  double times = 0;
  std::size_t counted = 0;
  std::size_t near = 0;
  bool again = false;
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    const CloudColumn& column = cloud.columns[c];
    again = again && same_firing(cloud.columns[c - 1], column);
    if (c > 0) position += azimuth_step(cloud.columns[c - 1], column);
    Firing firing{position, 0, 0, BeamStatus::none};
    while (near < cloud.too_near.size() && cloud.too_near[near].column < c) ++near;
    for (std::size_t n = near; n < cloud.too_near.size() && cloud.too_near[n].column == c; ++n) {
      if (cloud.too_near[n].ring == spec_.ring) firing.status = BeamStatus::near;
    }
    if (const CloudPoint* point = point_in_column(cloud, c, spec_.ring)) {
      const double x = static_cast<double>(point->x);
      const double y = static_cast<double>(point->y);
      // Azimuth counts clockwise.
      const double offset = std::remainder(-std::atan2(y, x) - static_cast<double>(column.azimuth), turn);
      firing = {position + offset, static_cast<float>(std::hypot(x, y)), point->intensity, BeamStatus::hit};
      if (firing.range > direction_range_m) {
        offsets += offset;
        times += static_cast<double>(point->time) - seconds(column.stamp - cloud.stamp);
        ++counted;
      }
    }
    // Perhaps the ring was not fired.
    if (cloud.bank_by_bank && firing.status == BeamStatus::none) continue;
    if (again)
      merge_echo(firing);
    else
      firings_.push_back(firing);
    again = true;
  }
  if (counted == 0) return;
  offset_rad_ = offsets / static_cast<double>(counted);
  offset_time_ = span_from_seconds(times / static_cast<double>(counted));
}

void RingScan::merge_echo(const Firing& echo) {
  Firing& kept = firings_.back();
  if (echo.status == BeamStatus::none) return;
  const bool nearer =
      echo.status == BeamStatus::hit && (kept.status != BeamStatus::hit || echo.range < kept.range);
  if (nearer || kept.status == BeamStatus::none) kept = echo;
}

void RingScan::find_positions(const Cloud& cloud) {
  const double first = static_cast<double>(cloud.columns.front().azimuth) + offset_rad_;
  if (!begin_known_) {
    begin_known_ = true;
    begin_ = first;
  }
  first_position_ = std::remainder(first - begin_, turn);
  for (Firing& firing : firings_) {
    // A hit's own direction is known already.
    const double offset = firing.status == BeamStatus::hit ? 0 : offset_rad_;
    firing.position += offset + first_position_ - offset_rad_;
  }
}

double RingScan::mean_step(double limit) const {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 1; i < firings_.size(); ++i) {
    const double step = firings_[i].position - firings_[i - 1].position;
    if (step > limit) continue;
    sum += step;
    ++count;
  }
  return count == 0 ? 0 : sum / static_cast<double>(count);
}

bool RingScan::measure(const Cloud& cloud) {
  if (firings_.size() < 2) return false;
  const double time = seconds(cloud.columns.back().stamp - cloud.columns.front().stamp);
  double angle = 0;
  for (std::size_t c = 1; c < cloud.columns.size(); ++c)
    angle += azimuth_step(cloud.columns[c - 1], cloud.columns[c]);
  if (!(time > 0) || !(angle > 0)) return false;
  rate_ = angle / time;
  // Twice, so that neither a hidden sector nor lost packets count as the usual step.
  step_ = mean_step(turn);
  step_ = mean_step(2.5 * step_);
  step_ = mean_step(gap_steps * step_);
  return step_ > 0;
}

bool RingScan::same_surface(const Firing& a, const Firing& b) const {
  if (a.status != BeamStatus::hit || b.status != BeamStatus::hit) return false;
  const double limit = steepest * std::fabs(b.position - a.position) * std::min(a.range, b.range);
  return std::fabs(a.range - b.range) <= limit;
}

void RingScan::put(PlanarScan& scan, std::size_t beam, double range, float intensity) const {
  scan.set_measured(beam, static_cast<float>(range));
  if (scan.statuses[beam] == BeamStatus::hit) scan.intensities[beam] = intensity;
}

void RingScan::put(PlanarScan& scan, std::size_t beam, const Firing& firing) const {
  if (firing.status == BeamStatus::hit)
    put(scan, beam, static_cast<double>(firing.range), firing.intensity);
  else
    scan.set_without_hit(beam, firing.status);
}

/// The beam at `at` between two firings, or a bit beyond both at an end of the revolution.
void RingScan::set_beam(PlanarScan& scan, std::size_t beam, const Firing& a, const Firing& b) const {
  const double at = static_cast<double>(beam) * increment_;
  const double apart = b.position - a.position;
  const double into = at - a.position;
  const Firing& nearest = into * 2 <= apart ? a : b;
  const bool beyond = into < 0 || into > apart;
  const bool gap = apart > gap_steps * step_;
  const double reach = beyond ? reach_steps_at_ends : reach_steps;
  if ((beyond || gap) && std::fabs(at - nearest.position) > reach * step_) return;
  if (gap || !(apart > 0) || !same_surface(a, b)) {
    put(scan, beam, nearest);
    return;
  }
  const double ra = static_cast<double>(a.range);
  const double rb = static_cast<double>(b.range);
  const double range = ra * rb * std::sin(apart) / (ra * std::sin(into) + rb * std::sin(apart - into));
  put(scan, beam, range, nearest.intensity);
}

void RingScan::keep_nearer(PlanarScan& scan, std::size_t beam, const Firing& firing) const {
  if (firing.status != BeamStatus::hit || scan.statuses[beam] == BeamStatus::near) return;
  const double off = std::fabs(firing.position - static_cast<double>(beam) * increment_);
  const double range = static_cast<double>(firing.range);
  const bool same = scan.statuses[beam] == BeamStatus::hit &&
                    range * (1 + steepest * off) >= static_cast<double>(scan.ranges[beam]);
  if (!same && range >= spec_.range_min && range <= spec_.range_max) put(scan, beam, range, firing.intensity);
}

void RingScan::fill(PlanarScan& scan) const {
  std::size_t before = 0;
  for (std::size_t beam = 0; beam < beams_; ++beam) {
    const double at = static_cast<double>(beam) * increment_;
    while (before + 2 < firings_.size() && firings_[before + 1].position <= at) ++before;
    set_beam(scan, beam, firings_[before], firings_[before + 1]);
  }
  for (const Firing& firing : firings_) {
    const long beam = std::lround(firing.position / increment_);
    if (beam >= 0 && beam < static_cast<long>(beams_))
      keep_nearer(scan, static_cast<std::size_t>(beam), firing);
  }
}

bool RingScan::convert(const Cloud& cloud, PlanarScan& scan) {
  if (cloud.columns.empty()) return false;
  gather(cloud);
  find_positions(cloud);  // a hit has the offset of its ring already, a beam without return has not
  if (!measure(cloud)) return false;
  scan.frame_id = cloud.frame_id;
  scan.reset(beams_);
  scan.range_min = static_cast<float>(spec_.range_min);
  scan.range_max = static_cast<float>(spec_.range_max);
  scan.set_angles(static_cast<float>(std::remainder(-begin_, turn)), static_cast<float>(-increment_));
  scan.scan_time = static_cast<float>(turn / rate_);
  scan.time_increment = static_cast<float>(increment_ / rate_);
  scan.stamp = cloud.columns.front().stamp + offset_time_ - span_from_seconds(first_position_ / rate_);
  fill(scan);
  return true;
}

}  // namespace lidard
