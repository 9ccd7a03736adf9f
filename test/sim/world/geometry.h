// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "core/base/pose.h"
#include "test/sim/world/motion.h"

namespace lidard::sim {

constexpr double no_hit = std::numeric_limits<double>::infinity();

/// A half line; the direction has length 1, so that the parameter is a distance in m.
struct Ray {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
};

Ray transform(const Pose& pose, const Ray& ray);

/// The horizontal plane at height z (m).
struct Ground {
  double z = 0;
};
/// A vertical rectangle over the segment from a to b (m), seen from both sides.
struct Wall {
  Eigen::Vector2d a, b;
  double z_min = 0;
  double z_max = 0;
};
/// A box around the origin of its own frame; full edge lengths in m.
struct Box {
  Eigen::Vector3d size = Eigen::Vector3d::Ones();
};
/// An upright cylinder around the origin of its own frame (m), closed at both ends.
struct Cylinder {
  double radius = 0;
  double height = 0;
};

/// Distance (m) to the first point where the ray meets the surface, `no_hit` if it does not. Solids are hit
/// from inside too.
double distance(const Ground& ground, const Ray& ray);
double distance(const Wall& wall, const Ray& ray);
double distance(const Box& box, const Ray& ray);
double distance(const Cylinder& cylinder, const Ray& ray);

/// Something that beams can hit. Solids stand at `pose`, or move through `waypoints` when there are any (then
/// `pose` holds their rotation before the yaw of the waypoints).
struct Object {
  std::variant<Wall, Box, Cylinder> shape;
  Pose pose = Pose::Identity();
  std::vector<Waypoint> waypoints;
  double reflectivity = 0.5;  ///< 0..1 of a white diffuse surface; above 1 a retro-reflector
};

/// The pose of an object `time` seconds after the start of the scene.
Pose pose_at(const Object& object, double time);

/// What a ray meets first.
struct Hit {
  double distance = no_hit;  ///< m
  double reflectivity = 0;
};

/// Keeps the nearer of `nearest` and the object, at `time` s after the start of the scene.
void cast(const Object& object, const Ray& ray, double time, Hit& nearest);

}  // namespace lidard::sim
