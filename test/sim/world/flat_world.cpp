// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/world/flat_world.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lidard::sim {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

}  // namespace

void FlatWorld::add_wall(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { walls_.push_back({a, b}); }

void FlatWorld::add_box(const Eigen::Vector2d& center, const Eigen::Vector2d& half, double yaw) {
  const Eigen::Vector2d u(std::cos(yaw), std::sin(yaw));
  const Eigen::Vector2d along = u * half.x();
  const Eigen::Vector2d across = Eigen::Vector2d(-u.y(), u.x()) * half.y();
  const Eigen::Vector2d corners[] = {center - along - across, center + along - across,
                                     center + along + across, center - along + across};
  for (int i = 0; i < 4; ++i) add_wall(corners[i], corners[(i + 1) % 4]);
}

double FlatWorld::cast(const Eigen::Vector2d& origin, double angle) const {
  const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
  double nearest = std::numeric_limits<double>::infinity();
  for (const Wall& wall : walls_) {
    const Eigen::Vector2d edge = wall.b - wall.a;
    const Eigen::Vector2d to = wall.a - origin;
    const double slope = cross(ray, edge);
    if (std::abs(slope) < 1e-12) continue;
    const double along = cross(to, edge) / slope;
    const double share = cross(to, ray) / slope;
    if (along > 0 && share >= 0 && share <= 1) nearest = std::min(nearest, along);
  }
  return nearest;
}

double FlatWorld::distance(const Eigen::Vector2d& point) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Wall& wall : walls_) {
    const Eigen::Vector2d edge = wall.b - wall.a;
    const double along = std::clamp((point - wall.a).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (wall.a + along * edge - point).norm());
  }
  return nearest;
}

FlatWorld FlatWorld::seen_from(const Eigen::Vector2d& center, double yaw) const {
  const Eigen::Rotation2Dd back(-yaw);
  FlatWorld turned;
  for (const Wall& wall : walls_) turned.add_wall(back * (wall.a - center), back * (wall.b - center));
  return turned;
}

bool FlatScanner::sees(const FlatWorld& world, const Eigen::Vector2d& point) const {
  const Eigen::Vector2d to = point - at;
  const double distance = to.norm();
  const double angle = std::atan2(to.y(), to.x());
  if (distance > range_max || std::abs(std::remainder(angle - yaw, 2 * pi_d)) > field / 2) return false;
  return world.cast(at, angle) >= distance - 0.02;
}

void FlatScanner::measure(const FlatWorld& world, Rng& rng, PlanarScan& scan) const {
  measure(
      world, [](std::size_t) { return Pose2(); }, rng, scan);
}

void FlatScanner::measure(const FlatWorld& world, const std::function<Pose2(std::size_t)>& place, Rng& rng,
                          PlanarScan& scan) const {
  scan.reset(static_cast<std::size_t>(std::lround(field / increment)) + 1, 1, true);
  scan.set_angles(static_cast<float>(-field / 2), static_cast<float>(increment));
  scan.range_max = static_cast<float>(range_max);
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const Pose2 vehicle = place(i);
    const Eigen::Vector2d from = Eigen::Vector2d(vehicle.x, vehicle.y) + Eigen::Rotation2Dd(vehicle.yaw) * at;
    const double angle = vehicle.yaw + yaw - field / 2 + static_cast<double>(i) * increment;
    double range = world.cast(from, angle);
    if (spot > 0) {
      const double left = world.cast(from, angle + spot);
      const double right = world.cast(from, angle - spot);
      const bool touches_two = std::abs(left - right) > 0.15 && std::abs(left - right) < 5;
      const double mixed = left + rng.uniform() * (right - left);
      if (touches_two && rng.uniform() < 0.5) range = mixed;
    }
    range += noise * rng.gaussian();
    scan.intensities[i] = 100;
    if (range <= range_max && range > 0)
      scan.set_hit(i, static_cast<float>(range));
    else
      scan.set_without_hit(i, BeamStatus::none);
  }
}

}  // namespace lidard::sim
