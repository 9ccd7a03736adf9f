// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/placement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/base/angle.h"

namespace lidard {
namespace {

using Eigen::Vector2d;

constexpr double widest_gate = 1.5, finest_gate = 0.03, gate_shrinks = 0.85;
constexpr double widest_angle = 35 * rad_per_deg, finest_angle = 5 * rad_per_deg;
// A return of a multi-plane lidar stands for what a scanner meets in its plane if it is not lower or higher,
// m: the ground lies below, and most things that stand there reach down to the plane.
constexpr double below_plane_m = 0.15, above_plane_m = 0.6;
constexpr std::size_t judged_returns = 600;
constexpr double stiffness = 0.003;  // of all directions, by what the surfaces show of all

/// Sums of the normal equations for x, y and yaw.
struct Sums {
  Eigen::Matrix3d levers = Eigen::Matrix3d::Identity() * 1e-6;
  Eigen::Vector3d pulls = Eigen::Vector3d::Zero();
  void add(const Eigen::Vector3d& lever, double off, double gate) {
    const double weight = 1 / std::pow(1 + off * off / (gate * gate), 2);  // Geman-McClure
    levers += weight * lever * lever.transpose();
    pulls -= weight * off * lever;
  }
};

/// The distance across the nearest of `lines` with about this normal; false: none within the gate.
bool nearest_line(const std::vector<Surface>& lines, const Vector2d& point, const Vector2d& normal,
                  double gate, double cosine, const Surface*& nearest, double& across) {
  nearest = nullptr;
  for (const Surface& line : lines) {
    const Vector2d d = point - line.middle;
    const double off = line.normal.dot(d), s = line.along.dot(d);
    if (std::abs(off) >= gate || (nearest != nullptr && std::abs(off) >= std::abs(across))) continue;
    if (line.normal.dot(normal) < cosine || s < line.from - gate / 2 || s > line.to + gate / 2) continue;
    nearest = &line, across = off;
  }
  return nearest != nullptr;
}

void add_points(const std::vector<Surface>& lines, const std::vector<Surface>& points,
                const PlanarPose& lines_from_points, double gate, double cosine, bool inverse, Sums& sums) {
  const Surface* line = nullptr;
  double across = 0;
  for (const Surface& surface : points) {
    const Vector2d normal = lines_from_points.turned(surface.normal);
    for (std::size_t i = 0; i < surface.points.size(); i += 2) {
      const Vector2d q = lines_from_points * surface.points[i];
      if (!nearest_line(lines, q, normal, gate, cosine, line, across)) continue;
      if (!inverse) {
        const Vector2d turned = q - Vector2d(lines_from_points.x, lines_from_points.y);
        sums.add({line->normal.x(), line->normal.y(),
                  line->normal.y() * turned.x() - line->normal.x() * turned.y()},
                 across, gate);
        continue;
      }
      // The pose moves the line in place of the point.
      const PlanarPose back = lines_from_points.inverse();
      const Vector2d n = back.turned(line->normal);
      const Vector2d p = surface.points[i] - Vector2d(back.x, back.y);
      sums.add({-n.x(), -n.y(), -(n.y() * p.x() - n.x() * p.y())}, across, gate);
    }
  }
}

}  // namespace

Vector2d PlanarPose::turned(const Vector2d& p) const {
  const double c = std::cos(yaw), s = std::sin(yaw);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

PlanarPose PlanarPose::operator*(const PlanarPose& other) const {
  const Vector2d at = *this * Vector2d(other.x, other.y);
  return {at.x(), at.y(), std::remainder(yaw + other.yaw, two_pi)};
}

PlanarPose PlanarPose::inverse() const {
  const Vector2d back = PlanarPose{0, 0, -yaw}.turned({x, y});
  return {-back.x(), -back.y(), -yaw};
}

SeenPlace mirrored(SeenPlace place) {
  for (StillView& view : place.views) {
    for (StillBeam& beam : view.beams) beam.point.y() = -beam.point.y();
  }
  for (Surface& surface : place.surfaces) {
    surface.middle.y() = -surface.middle.y(), surface.normal.y() = -surface.normal.y();
    surface.along = {-surface.along.x(), surface.along.y()};
    std::swap(surface.from, surface.to);
    surface.from = -surface.from, surface.to = -surface.to;
    surface.slope_by_range = -surface.slope_by_range;
    for (Vector2d& point : surface.points) point.y() = -point.y();
  }
  return place;
}

PlanarPose match_surfaces(const std::vector<Surface>& a, const std::vector<Surface>& b, PlanarPose pose,
                          double gate) {
  for (; gate > finest_gate; gate *= gate_shrinks) {
    const double cosine = std::cos(std::max(finest_angle, widest_angle * gate / widest_gate));
    Sums sums;
    add_points(a, b, pose, gate, cosine, false, sums);
    add_points(b, a, pose.inverse(), gate, cosine, true, sums);
    // Along a corridor, noise alone pulls: without this it pulls far.
    sums.levers.diagonal().head<2>().array() += stiffness * sums.levers.diagonal().head<2>().sum();
    const Eigen::Vector3d step = sums.levers.ldlt().solve(sums.pulls);
    if (!step.allFinite()) break;
    pose.x += std::clamp(step[0], -gate, gate), pose.y += std::clamp(step[1], -gate, gate);
    pose.yaw = std::remainder(pose.yaw + std::clamp(step[2], -0.3, 0.3), two_pi);
  }
  return pose;
}

namespace {

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

void judge(const ByAzimuth& seen, const SeenPlace& other, double height, const PlanarPose& pose,
           Agreement& result) {
  std::size_t count = 0;
  for (const StillView& view : other.views) count += view.beams.size();
  const std::size_t stride = std::max<std::size_t>(1, count / judged_returns / (other.is_planar() ? 1 : 4));
  std::size_t number = 0;
  for (const StillView& view : other.views) {
    for (const StillBeam& beam : view.beams) {
      if (++number % stride != 0 || !beam.is_hit()) continue;
      const double above = beam.height + other.height - height;
      if (!other.is_planar() && (above < -below_plane_m || above > above_plane_m)) continue;
      const Vector2d q = pose * beam.point;
      const double range = q.norm(), slack = 0.08 + 0.01 * range;
      bool confirms = false, all_beyond = true;
      std::size_t met = 0;
      seen.around(std::atan2(q.y(), q.x()), [&](const StillBeam& own) {
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

Agreement agreement(const SeenPlace& a, const SeenPlace& b, const PlanarPose& a_from_b) {
  Agreement result;
  if (a.is_planar()) judge(ByAzimuth(a.views[0]), b, a.height, a_from_b, result);
  if (b.is_planar()) judge(ByAzimuth(b.views[0]), a, b.height, a_from_b.inverse(), result);
  return result;
}

}  // namespace lidard
