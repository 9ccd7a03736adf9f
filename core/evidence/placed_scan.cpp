// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/placed_scan.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

constexpr float same_position = 0.1F;  // m, of a lone return in two sweeps

/// Converts the beams of one scan to surfaces and free ranges.
class Conditioner {
 public:
  Conditioner(const PlanarScan& scan, const BeamRays& rays, const SourceSettings& settings, PlacedScan& sweep)
      : scan_(scan),
        rays_(rays),
        settings_(settings),
        sweep_(sweep),
        sector_(sector_between(settings.angle_min, settings.angle_max)),
        nearest_(static_cast<float>(settings.range_min)),
        farthest_(static_cast<float>(settings.range_max)),
        open_(std::min(static_cast<float>(settings.no_return_free_range), scan.range_max)) {}

  void run() {
    const std::size_t n = scan_.beams;
    sweep_.range.assign(n, 0);
    sweep_.kind.assign(n, Return::nothing);
    sweep_.intensity.assign(scan_.intensities.empty() ? 0 : n, 0);
    sweep_.free_from.assign(n, 0);
    sweep_.free_to.assign(n, 0);
    sweep_.early_returns.clear();
    sweep_.passes_vehicle.resize(n, 0);
    for (std::size_t beam = 0; beam < n; ++beam) read_beam(beam);
    link_neighbours(rays_, settings_.noise, sweep_);
    if (settings_.veil_filter && n > 2) mark_mixed_pixels(rays_, settings_.noise, sweep_);
    for (std::size_t beam = 0; beam < n; ++beam) {
      if (sweep_.kind[beam] != Return::surface) continue;
      free_in_band(beam, sweep_.range[beam]);
    }
    shorten_mixed_pixels();
    for (std::size_t beam = 0; beam < n; ++beam) {
      if (sweep_.kind[beam] != Return::nothing) drop_outside_band(beam);
    }
    find_lone_returns();
  }

 private:
  bool wanted(std::size_t beam) const {
    return sector_.holds(rays_.angle_min + static_cast<double>(beam) * rays_.increment);
  }

  bool usable(std::size_t i) const {
    return scan_.statuses[i] == BeamStatus::hit && scan_.ranges[i] >= nearest_ &&
           scan_.ranges[i] <= farthest_;
  }

  /// Index of the return that counts, or of the first echo if none counts.
  std::size_t chosen_echo(std::size_t beam) const {
    std::size_t chosen = scan_.index(beam);
    bool found = usable(chosen);
    for (std::size_t echo = 1; echo < scan_.echoes; ++echo) {
      const std::size_t i = scan_.index(beam, echo);
      if (!usable(i)) continue;
      const bool nearer = scan_.ranges[i] < scan_.ranges[chosen];
      bool better = settings_.echoes == EchoChoice::first ? nearer : !nearer;
      if (settings_.echoes == EchoChoice::strongest && !scan_.intensities.empty())
        better = scan_.intensities[i] > scan_.intensities[chosen];
      if (!found || better) chosen = i;
      found = true;
    }
    return chosen;
  }

  void read_beam(std::size_t beam) {
    if (!wanted(beam)) return;
    const std::size_t i = scan_.echoes > 1 ? chosen_echo(beam) : beam;
    if (usable(i))
      accept_hit(beam, i);
    else if (scan_.statuses[i] == BeamStatus::none)
      accept_none(beam);
  }

  void accept_hit(std::size_t beam, std::size_t i) {
    const float range = scan_.ranges[i];
    if (scan_.echoes > 1) keep_early_echoes(beam, i);
    if (const float own = rays_.own_from(beam, range); std::isfinite(own)) {
      ++sweep_.own_returns;
      free_in_band(beam, own);
      return;
    }
    if (range > rays_.blocked_at[beam]) {
      ++sweep_.seen_through;
      sweep_.passes_vehicle[beam] = 1;
    }
    sweep_.kind[beam] = Return::surface;
    sweep_.range[beam] = range;
    if (!sweep_.intensity.empty()) sweep_.intensity[beam] = scan_.intensities[i];
  }

  void accept_none(std::size_t beam) {
    const bool passes = sweep_.passes_vehicle[beam] != 0;
    if (rays_.from_inside[beam] != 0 && !passes) return;
    free_in_band(beam, passes ? open_ : std::min(open_, rays_.blocked_at[beam]));
  }

  /// True for a return that is not the vehicle's.
  bool counts(std::size_t beam, std::size_t i) const {
    return usable(i) && !std::isfinite(rays_.own_from(beam, scan_.ranges[i]));
  }

  /// The way beyond an early echo is not free, although later echoes were measured through it.
  float to_first_echo(std::size_t beam, float to) const {
    for (std::size_t echo = 0; echo < scan_.echoes; ++echo) {
      const std::size_t i = scan_.index(beam, echo);
      if (counts(beam, i)) to = std::min(to, scan_.ranges[i]);
    }
    return to;
  }

  void keep_early_echoes(std::size_t beam, std::size_t chosen) {
    if (settings_.echoes != EchoChoice::all) return;
    for (std::size_t echo = 0; echo < scan_.echoes; ++echo) {
      const std::size_t i = scan_.index(beam, echo);
      const float r = scan_.ranges[i];
      if (i == chosen || !counts(beam, i) || r >= scan_.ranges[chosen]) continue;
      if (r < rays_.band_begin[beam] || r > rays_.band_end[beam]) continue;
      sweep_.early_returns.push_back({beam, r, scan_.intensities.empty() ? 0 : scan_.intensities[i]});
    }
  }

  /// Drops a return outside the height band; the free part of its beam stays.
  void drop_outside_band(std::size_t beam) {
    const float r = sweep_.range[beam];
    if (r >= rays_.band_begin[beam] && r <= rays_.band_end[beam]) return;
    sweep_.kind[beam] = Return::nothing;
    sweep_.linked[beam] = 0;
    if (beam > 0) sweep_.linked[beam - 1] = 0;
  }

  /// The beam of a mixed pixel is free as far as the nearer of its neighbours.
  void shorten_mixed_pixels() {
    for (std::size_t i = 1; i + 1 < sweep_.kind.size(); ++i) {
      if (sweep_.kind[i] != Return::mixed_pixel) continue;
      free_in_band(i, std::min(sweep_.range[i - 1], sweep_.range[i + 1]));
    }
  }

  void find_lone_returns() {
    sweep_.lone_before.swap(sweep_.lone_returns);
    sweep_.lone_returns.clear();
    auto before = sweep_.lone_before.begin();
    for (std::size_t i = 1; i + 1 < sweep_.kind.size(); ++i) {
      if (sweep_.kind[i] != Return::surface || sweep_.linked[i - 1] != 0 || sweep_.linked[i] != 0) continue;
      const float to = sweep_.free_to[i], range = sweep_.range[i];
      const float beside = std::min(sweep_.free_to[i - 1], sweep_.free_to[i + 1]);
      if (!(to > 0 && beside >= to + PlacedScan::lone_depth)) continue;
      while (before != sweep_.lone_before.end() && before->beam + 1 < i) ++before;
      bool thing = false;
      for (auto at = before; at != sweep_.lone_before.end() && at->beam <= i + 1; ++at)
        thing = thing || std::fabs(at->range - range) < same_position;
      sweep_.lone_returns.push_back({i, range, thing});
    }
  }

  /// Marks the beam free up to range `to`, within the height band.
  void free_in_band(std::size_t beam, float to) {
    if (scan_.echoes > 1 && settings_.echoes == EchoChoice::all) to = to_first_echo(beam, to);
    const float end = std::min(to, rays_.band_end[beam]);
    const float observed_from = scan_.free_from.empty() ? 0 : scan_.free_from[beam];
    const float begin = std::max(rays_.band_begin[beam], observed_from);
    if (end <= begin) return;
    sweep_.free_from[beam] = begin * rays_.level[beam];
    sweep_.free_to[beam] = end * rays_.level[beam];
  }

  const PlanarScan& scan_;
  const BeamRays& rays_;
  const SourceSettings& settings_;
  PlacedScan& sweep_;
  Sector sector_;
  float nearest_;
  float farthest_;
  float open_;  // m, free range of a beam without return
};

/// Transforms returns of a vehicle at rest.
void transform_standing(const BeamRays& rays, PlacedScan& sweep) {
  const auto x = static_cast<float>(rays.pose.translation().x());
  const auto y = static_cast<float>(rays.pose.translation().y());
  for (std::size_t beam = 0; beam < sweep.kind.size(); ++beam) {
    if (sweep.kind[beam] == Return::nothing) continue;
    sweep.x[beam] = x + sweep.range[beam] * rays.x[beam];
    sweep.y[beam] = y + sweep.range[beam] * rays.y[beam];
  }
  for (const PlacedScan::EarlyReturn& early : sweep.early_returns) {
    sweep.early_echoes.push_back(
        {x + early.range * rays.x[early.beam], y + early.range * rays.y[early.beam], early.intensity});
  }
}

Eigen::Vector3d ray_of(const BeamRays& rays, std::size_t beam) {
  return Eigen::Vector3f(rays.x[beam], rays.y[beam], rays.z[beam]).cast<double>();
}

/// Transforms returns and the ends of free ways of the beams of a stretch, in one component of the plane.
void transform_stretch(const BeamRays& rays, const SweepMotion::Stretch& stretch, Eigen::Index row,
                       PlacedScan& sweep, float* at, float* free_end, float* origin) {
  const Eigen::Vector4d here = rays.pose.translation().homogeneous();
  const double own = here[row], from = stretch.from.row(row) * here, change = stretch.change.row(row) * here;
  const Eigen::Vector4d turn = stretch.from.row(row), turning = stretch.change.row(row);
  const double a = turn[0], b = turn[1], c = turn[2], da = turning[0], db = turning[1], dc = turning[2];
  for (std::size_t beam = stretch.begin; beam < stretch.end; ++beam) {
    const auto since = static_cast<double>(beam - stretch.begin);
    const double ray = (a + since * da) * static_cast<double>(rays.x[beam]) +
                       (b + since * db) * static_cast<double>(rays.y[beam]) +
                       (c + since * dc) * static_cast<double>(rays.z[beam]);
    const double begin = from + since * change;
    const auto end = static_cast<double>(sweep.free_to[beam] / rays.level[beam]);
    at[beam] = static_cast<float>(begin + static_cast<double>(sweep.range[beam]) * ray);
    free_end[beam] = static_cast<float>(begin + end * ray - own);
    origin[beam] = static_cast<float>(begin - own);
  }
}

/// Transforms returns and the ends of free ways of a moving vehicle.
void transform_moving(const BeamRays& rays, const SweepMotion& motion, PlacedScan& sweep) {
  const Eigen::Vector3d& here = rays.pose.translation();
  sweep.free_x.resize(sweep.kind.size());
  sweep.free_y.resize(sweep.kind.size());
  sweep.origin_x.resize(sweep.kind.size());
  sweep.origin_y.resize(sweep.kind.size());
  for (const SweepMotion::Stretch& stretch : motion.stretches()) {
    transform_stretch(rays, stretch, 0, sweep, sweep.x.data(), sweep.free_x.data(), sweep.origin_x.data());
    transform_stretch(rays, stretch, 1, sweep, sweep.y.data(), sweep.free_y.data(), sweep.origin_y.data());
  }
  for (const PlacedScan::EarlyReturn& early : sweep.early_returns) {
    const Eigen::Vector3d p =
        motion.moved(early.beam, here + static_cast<double>(early.range) * ray_of(rays, early.beam));
    sweep.early_echoes.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), early.intensity});
  }
}

}  // namespace

void measure(const PlanarScan& scan, const BeamRays& rays, const SourceSettings& settings,
             PlacedScan& sweep) {
  Conditioner(scan, rays, settings, sweep).run();
}

void transform(const BeamRays& rays, const SweepMotion& motion, double noise, PlacedScan& sweep) {
  sweep.x.resize(sweep.kind.size());
  sweep.y.resize(sweep.kind.size());
  sweep.early_echoes.clear();
  sweep.moved = !motion.stands();
  if (sweep.moved)
    transform_moving(rays, motion, sweep);
  else
    transform_standing(rays, sweep);
  find_corners(noise, sweep);
}

void condition(const PlanarScan& scan, const BeamRays& rays, const SourceSettings& settings,
               PlacedScan& sweep) {
  measure(scan, rays, settings, sweep);
  transform(rays, SweepMotion(), settings.noise, sweep);
}

}  // namespace lidard
