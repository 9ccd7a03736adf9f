// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/ground.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "core/base/angle.h"

namespace lidard {
namespace {

using Eigen::Vector3d;

constexpr int tries = 500;
constexpr double inlier_m = 0.04, farthest_m = 25, height_slack_m = 0.7;
const double steepest = std::cos(25 * rad_per_deg);
constexpr std::size_t fewest = 200;
constexpr double range_sigma = 0.01, smallest_sigma = 0.0005;  // m

/// True if one look in most directions meets the plane near and far. Where a ring meets walls, its returns
/// lie in a plane, too, but at one distance each.
bool is_seen_near_and_far(const std::vector<Vector3d>& points, const GroundPlane& plane) {
  constexpr std::size_t sectors = 360;
  constexpr double far_by_near = 1.3, least_share = 1.0 / 3;
  std::array<double, sectors> nearest{}, farthest{};
  for (const Vector3d& p : points) {
    if (std::abs(plane.up.dot(p) + plane.height) > inlier_m) continue;
    const double turns = std::atan2(p.y(), p.x()) / two_pi + 0.5;
    const std::size_t at = std::min(static_cast<std::size_t>(turns * sectors), sectors - 1);
    nearest[at] = nearest[at] == 0 ? p.norm() : std::min(nearest[at], p.norm());
    farthest[at] = std::max(farthest[at], p.norm());
  }
  double met = 0, deep = 0;
  for (std::size_t i = 0; i < sectors; ++i) {
    met += nearest[i] > 0 ? 1 : 0;
    deep += farthest[i] > far_by_near * nearest[i] ? 1 : 0;
  }
  return deep > least_share * met;
}

}  // namespace

std::optional<GroundPlane> find_ground(const std::vector<Vector3d>& all, const Pose& base_from_sensor) {
  const Vector3d up = base_from_sensor.linear().transpose() * Vector3d::UnitZ();
  const double height = base_from_sensor.translation().z();
  std::vector<Vector3d> points;
  for (const Vector3d& p : all) {
    // A tilt that is 25 degrees off lifts what lies 1 m ahead by 0.47 m.
    if (p.norm() < farthest_m && up.dot(p) < -0.3 * height &&
        up.dot(p) > -height - height_slack_m - 0.47 * p.norm())
      points.push_back(p);
  }
  if (points.size() < fewest) return std::nullopt;
  std::mt19937 random(12345);
  GroundPlane best;
  for (int i = 0; i < tries; ++i) {
    const auto any = [&]() -> const Vector3d& { return points[random() % points.size()]; };
    const Vector3d &a = any(), &b = any(), &c = any();
    Vector3d normal = (b - a).cross(c - a);
    if (normal.norm() < 0.5) continue;
    normal.normalize();
    if (normal.dot(up) < 0) normal = -normal;
    const double above = -normal.dot(a);
    if (normal.dot(up) < steepest || std::abs(above - height) > height_slack_m) continue;
    std::size_t met = 0;
    for (const Vector3d& p : points) met += std::abs(normal.dot(p) + above) < inlier_m ? 1 : 0;
    if (met > best.points) best = {normal, above, met};
  }
  if (best.points < fewest) return std::nullopt;
  // z = p x + q y - h in axes beside the normal; the noise of a flat beam hardly moves the ground.
  for (int round = 0; round < 5; ++round) {
    const Vector3d ahead = best.up.unitOrthogonal(), left = best.up.cross(ahead);
    Eigen::Matrix3d levers = Eigen::Matrix3d::Zero();
    Vector3d pulls = Vector3d::Zero();
    best.points = 0;
    for (const Vector3d& p : points) {
      const double off = best.up.dot(p) + best.height;
      if (std::abs(off) > inlier_m) continue;
      ++best.points;
      const double sigma = range_sigma * best.height / p.norm() + smallest_sigma;
      const Vector3d row(ahead.dot(p), left.dot(p), 1);
      levers += row * row.transpose() / (sigma * sigma);
      pulls += row * off / (sigma * sigma);
    }
    const Vector3d change = levers.ldlt().solve(pulls);
    if (!change.allFinite()) return std::nullopt;
    // off = change . row on the plane, so that the normal leans against the change.
    const Vector3d normal = best.up - change[0] * ahead - change[1] * left;
    best.height = (best.height - change[2]) / normal.norm();
    best.up = normal.normalized();
  }
  return is_seen_near_and_far(points, best) ? std::optional(best) : std::nullopt;
}

double yaw_of(const Eigen::Matrix3d& rotation) { return std::atan2(rotation(1, 0), rotation(0, 0)); }

Eigen::Matrix3d tilt_of(const Eigen::Matrix3d& rotation) {
  return Eigen::AngleAxisd(-yaw_of(rotation), Vector3d::UnitZ()).toRotationMatrix() * rotation;
}

Eigen::Matrix3d tilt_to(const Vector3d& up) {
  return tilt_of(Eigen::Quaterniond::FromTwoVectors(up, Vector3d::UnitZ()).toRotationMatrix());
}

}  // namespace lidard
