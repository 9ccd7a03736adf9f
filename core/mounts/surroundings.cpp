// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/surroundings.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

using Eigen::Vector2d;

// A return of a multi-plane lidar stands for what a scanner meets in its plane if it is not lower or higher,
// m: the ground lies below, and most things that stand there reach down to the plane.
constexpr double below_plane_m = 0.15, above_plane_m = 0.6;
constexpr std::size_t judged_returns = 600;

/// Azimuths of the beams of a view for searching, ascending.
struct ByAzimuth {
  explicit ByAzimuth(const StillView& seen) : view(seen) {
    for (std::size_t i = 0; i < view.beams.size(); ++i) {
      if (!std::isnan(view.beams[i].range))
        order.emplace_back(std::atan2(view.beams[i].point.y(), view.beams[i].point.x()), i);
    }
    std::sort(order.begin(), order.end());
  }
  /// Calls `visit` with beams within two steps of the azimuth.
  template <class Visit>
  void around(double azimuth, Visit visit) const {
    const double reach = 2.5 * view.step;
    auto at =
        std::lower_bound(order.begin(), order.end(), std::pair<double, std::size_t>(azimuth - reach, 0));
    for (; at != order.end() && at->first <= azimuth + reach; ++at) visit(view.beams[at->second]);
  }
  const StillView& view;
  std::vector<std::pair<double, std::size_t>> order;
};

void judge(const ByAzimuth& view, const Surroundings& other, double height, const PlanarPose& pose,
           Agreement& result) {
  std::size_t count = 0;
  for (const StillView& ring : other.views) count += ring.beams.size();
  const std::size_t stride = std::max<std::size_t>(1, count / judged_returns / (other.is_planar() ? 1 : 4));
  std::size_t number = 0;
  for (const StillView& ring : other.views) {
    for (const StillBeam& beam : ring.beams) {
      if (++number % stride != 0 || !beam.is_hit()) continue;
      const double above = beam.height + other.height - height;
      if (!other.is_planar() && (above < -below_plane_m || above > above_plane_m)) continue;
      const Vector2d q = pose * beam.point;
      const double range = q.norm(), slack = 0.08 + 0.01 * range;
      bool confirms = false, all_beyond = true;
      std::size_t met = 0;
      view.around(std::atan2(q.y(), q.x()), [&](const StillBeam& own) {
        ++met;
        confirms = confirms || (own.is_hit() && std::abs(own.range - range) < slack);
        all_beyond = all_beyond && own.range > range + slack;
      });
      if (met < 3) continue;
      if (confirms)
        ++result.confirmed;
      else if (all_beyond)
        ++result.refuted;
    }
  }
}

}  // namespace

Surroundings mirrored(Surroundings seen) {
  for (StillView& view : seen.views) {
    for (StillBeam& beam : view.beams) beam.point.y() = -beam.point.y();
  }
  for (Surface& surface : seen.surfaces) {
    surface.middle.y() = -surface.middle.y(), surface.normal.y() = -surface.normal.y();
    surface.along = {-surface.along.x(), surface.along.y()};
    std::swap(surface.from, surface.to);
    surface.from = -surface.from, surface.to = -surface.to;
    surface.slope_by_range = -surface.slope_by_range;
    for (Vector2d& point : surface.points) point.y() = -point.y();
  }
  return seen;
}

Agreement agreement(const Surroundings& a, const Surroundings& b, const PlanarPose& a_from_b) {
  Agreement result;
  if (a.is_planar()) judge(ByAzimuth(a.views[0]), b, a.height, a_from_b, result);
  if (b.is_planar()) judge(ByAzimuth(b.views[0]), a, b.height, a_from_b.inverse(), result);
  return result;
}

}  // namespace lidard
