// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/surface_match.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/base/angle.h"

namespace lidard {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Of the coarse match. Gates: m and rad.
constexpr double finest_gate = 0.03, gate_shrinks = 0.85;
constexpr double widest_angle = 35 * rad_per_deg, finest_angle = 5 * rad_per_deg;
constexpr double stiffness = 0.003;  // of all directions, by what the surfaces show of all
// Of the fine match.
constexpr double paired_gate = 0.12, paired_slope = 5 * rad_per_deg, paired_overlap = 0.3;
// m, error that the returns of a surface have in common.
constexpr double common_error = 0.002;
constexpr double match_freedom = 5;  // of Student's distribution

/// By how much a move of x, y and yaw moves what is at `arm` from the centre along the normal.
Vector3d lever_of(const Vector2d& normal, const Vector2d& arm) {
  return {normal.x(), normal.y(), normal.y() * arm.x() - normal.x() * arm.y()};
}

/// Sums of the normal equations for x, y and yaw.
struct Sums {
  Eigen::Matrix3d levers = Eigen::Matrix3d::Identity() * 1e-6;
  Vector3d pulls = Vector3d::Zero();
  void add(const Vector3d& lever, double off, double gate) {
    const double weight = 1 / std::pow(1 + off * off / (gate * gate), 2);  // Geman-McClure
    levers += weight * lever * lever.transpose();
    pulls -= weight * off * lever;
  }
};

/// A line, and how far a point is off it, m.
struct NearLine {
  const Surface* line = nullptr;
  double across = 0;
};

/// The nearest of `lines` with about this normal; nullptr: none within the gate.
NearLine nearest_line(const std::vector<Surface>& lines, const Vector2d& point, const Vector2d& normal,
                      double gate, double cosine) {
  NearLine nearest;
  for (const Surface& line : lines) {
    const Vector2d d = point - line.middle;
    const double off = line.normal.dot(d), s = line.along.dot(d);
    if (std::abs(off) >= gate || (nearest.line != nullptr && std::abs(off) >= std::abs(nearest.across)))
      continue;
    if (line.normal.dot(normal) < cosine || s < line.from - gate / 2 || s > line.to + gate / 2) continue;
    nearest = {&line, off};
  }
  return nearest;
}

/// Calls visit(near line, point, the point in the frame of the lines) for every second point of the surfaces
/// that has a line within the gate.
template <class Visit>
void match_points(const std::vector<Surface>& lines, const std::vector<Surface>& points,
                  const PlanarPose& lines_from_points, double gate, double cosine, const Visit& visit) {
  for (const Surface& surface : points) {
    const Vector2d normal = lines_from_points.turned(surface.normal);
    for (std::size_t i = 0; i < surface.points.size(); i += 2) {
      const Vector2d q = lines_from_points * surface.points[i];
      const NearLine near = nearest_line(lines, q, normal, gate, cosine);
      if (near.line != nullptr) visit(near, surface.points[i], q);
    }
  }
}

const Surface* partner_of(const Surface& b, const std::vector<Surface>& a, const PlanarPose& a_from_b,
                          double gate) {
  const Vector2d middle = a_from_b * b.middle, normal = a_from_b.turned(b.normal);
  const Surface* nearest = nullptr;
  double least = gate;
  for (const Surface& surface : a) {
    if (surface.ring != b.ring || surface.normal.dot(normal) < std::cos(paired_slope)) continue;
    const double off = std::abs(surface.normal.dot(middle - surface.middle)),
                 along = surface.along.dot(middle - surface.middle);
    const double overlap =
        std::min(surface.to, along + b.length() / 2) - std::max(surface.from, along - b.length() / 2);
    if (off >= least || overlap < paired_overlap * std::min(surface.length(), b.length())) continue;
    nearest = &surface, least = off;
  }
  return nearest;
}

/// Adds what a pair of surfaces says: how far, and by what angle, they are apart.
void add_pair(const Surface& a, const Surface& b, const PlanarPose& pose, Eigen::Matrix3d& levers,
              Vector3d& pulls) {
  const Vector2d turned = pose.turned(b.middle), d = pose * b.middle - a.middle,
                 normal = pose.turned(b.normal);
  const double off = a.normal.dot(d), along = a.along.dot(d);
  const double slope =
      std::atan2(a.normal.x() * normal.y() - a.normal.y() * normal.x(), a.normal.dot(normal));
  const double length = std::min(a.length(), b.length()), bias = common_error * common_error;
  const double var_off = a.var_offset + b.var_offset + along * along * a.var_slope + bias,
               var_slope = a.var_slope + b.var_slope + 12 * bias / (length * length);
  const double chi = off * off / var_off + slope * slope / var_slope;
  const double trust = (match_freedom + 2) / (match_freedom + chi);
  const Vector3d lever = lever_of(a.normal, turned);
  levers += trust / var_off * lever * lever.transpose();
  levers(2, 2) += trust / var_slope;
  pulls -= trust / var_off * off * lever;
  pulls[2] -= trust / var_slope * slope;
}

}  // namespace

PlanarPose match_surfaces(const std::vector<Surface>& a, const std::vector<Surface>& b, PlanarPose pose,
                          double gate) {
  for (; gate > finest_gate; gate *= gate_shrinks) {
    const double cosine = std::cos(std::max(finest_angle, widest_angle * gate / coarsest_gate));
    Sums sums;
    match_points(a, b, pose, gate, cosine,
                 [&](const NearLine& near, const Vector2d& /*point*/, const Vector2d& q) {
                   sums.add(lever_of(near.line->normal, q - pose.position()), near.across, gate);
                 });
    // The other way round, the pose moves the line and not the point.
    const PlanarPose b_from_a = pose.inverse(), back = b_from_a.inverse();
    match_points(b, a, b_from_a, gate, cosine,
                 [&](const NearLine& near, const Vector2d& point, const Vector2d& /*q*/) {
                   const Vector2d normal = back.turned(near.line->normal);
                   sums.add(-lever_of(normal, point - back.position()), near.across, gate);
                 });
    // Along a corridor, noise alone pulls: without this it pulls far.
    sums.levers.diagonal().head<2>().array() += stiffness * sums.levers.diagonal().head<2>().sum();
    const Vector3d step = sums.levers.ldlt().solve(sums.pulls);
    if (!step.allFinite()) break;
    pose.x += std::clamp(step[0], -gate, gate), pose.y += std::clamp(step[1], -gate, gate);
    pose.yaw = std::remainder(pose.yaw + std::clamp(step[2], -0.3, 0.3), two_pi);
  }
  return pose;
}

MatchedPose refine_match(const std::vector<Surface>& a, const std::vector<Surface>& b, PlanarPose pose,
                         double gate) {
  MatchedPose match;
  constexpr int rounds = 6;
  for (int round = 0; round < rounds; ++round, gate /= 2) {
    Eigen::Matrix3d levers = Eigen::Matrix3d::Identity();
    Vector3d pulls = Vector3d::Zero();
    match.pairs = 0;
    for (const Surface& surface : b) {
      const Surface* const partner = partner_of(surface, a, pose, std::max(paired_gate, gate));
      if (partner == nullptr) continue;
      ++match.pairs;
      add_pair(*partner, surface, pose, levers, pulls);
    }
    const Vector3d change = levers.ldlt().solve(pulls);
    pose = {pose.x + change[0], pose.y + change[1], std::remainder(pose.yaw + change[2], two_pi)};
    match.information = levers;
  }
  match.pose = pose;
  return match;
}

}  // namespace lidard
