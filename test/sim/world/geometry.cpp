// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/world/geometry.h"

#include <algorithm>
#include <cmath>

namespace lidard::sim {
namespace {

/// The part of a ray inside a convex body; empty when begin > end.
struct Interval {
  double begin = -no_hit;
  double end = no_hit;

  void cut(double a, double b) {
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  }
  void clear() { begin = no_hit; }
  double first_surface() const {
    if (begin > end || end < 0) return no_hit;
    return begin >= 0 ? begin : end;
  }
};

void cut_slab(Interval& inside, double origin, double direction, double half) {
  if (direction != 0) {
    inside.cut((-half - origin) / direction, (half - origin) / direction);
  } else if (std::abs(origin) > half) {
    inside.clear();
  }
}

void cut_tube(Interval& inside, const Ray& ray, double radius) {
  const double ox = ray.origin.x();
  const double oy = ray.origin.y();
  const double dx = ray.direction.x();
  const double dy = ray.direction.y();
  const double a = dx * dx + dy * dy;
  const double b = ox * dx + oy * dy;
  const double c = ox * ox + oy * oy - radius * radius;
  if (a == 0) {
    if (c > 0) inside.clear();
    return;
  }
  // b * b - a * c, in the form that does not cancel for far and thin cylinders.
  const double miss = ox * dy - oy * dx;
  const double discriminant = a * radius * radius - miss * miss;
  if (discriminant < 0) {
    inside.clear();
    return;
  }
  const double root = std::sqrt(discriminant);
  inside.cut((-b - root) / a, (-b + root) / a);
}

// True if the ray surely passes a ball (radius squared in m2), with a margin for rounding: most objects are
// ruled out by this without a closer look.
bool passes(const Ray& ray, const Eigen::Vector3d& center, double radius_squared) {
  const double x = center.x() - ray.origin.x();
  const double y = center.y() - ray.origin.y();
  const double z = center.z() - ray.origin.z();
  const double along = x * ray.direction.x() + y * ray.direction.y() + z * ray.direction.z();
  const double apart = x * x + y * y + z * z;
  const double limit = radius_squared * 1.001 + 1e-6;
  return apart - along * along > limit || (along < 0 && apart > limit);
}

}  // namespace

Ray transform(const Pose& pose, const Ray& ray) { return {pose * ray.origin, pose.linear() * ray.direction}; }

double distance(const Ground& ground, const Ray& ray) {
  if (ray.direction.z() == 0) return no_hit;
  const double way = (ground.z - ray.origin.z()) / ray.direction.z();
  return way >= 0 ? way : no_hit;
}

double distance(const Wall& wall, const Ray& ray) {
  const Eigen::Vector2d along = wall.b - wall.a;
  const Eigen::Vector2d to_a = wall.a - ray.origin.head<2>();
  const Eigen::Vector2d d = ray.direction.head<2>();
  const double cross = d.x() * along.y() - d.y() * along.x();
  if (cross == 0) return no_hit;
  const double way = (to_a.x() * along.y() - to_a.y() * along.x()) / cross;
  const double share = (to_a.x() * d.y() - to_a.y() * d.x()) / cross;
  const double z = ray.origin.z() + way * ray.direction.z();
  const bool meets = way >= 0 && share >= 0 && share <= 1 && z >= wall.z_min && z <= wall.z_max;
  return meets ? way : no_hit;
}

double distance(const Box& box, const Ray& ray) {
  Interval inside;
  for (int axis = 0; axis < 3; ++axis) {
    cut_slab(inside, ray.origin[axis], ray.direction[axis], box.size[axis] / 2);
  }
  return inside.first_surface();
}

double distance(const Cylinder& cylinder, const Ray& ray) {
  Interval inside;
  cut_slab(inside, ray.origin.z(), ray.direction.z(), cylinder.height / 2);
  cut_tube(inside, ray, cylinder.radius);
  return inside.first_surface();
}

Pose pose_at(const Object& object, double time) {
  if (object.waypoints.empty()) return object.pose;
  const Waypoint place = interpolate(object.waypoints, time);
  Pose pose = make_pose(place.position, {0, 0, place.yaw});
  pose.linear() = pose.linear() * object.pose.linear();
  return pose;
}

void cast(const Object& object, const Ray& ray, double time, Hit& nearest) {
  double way = no_hit;
  if (const auto* wall = std::get_if<Wall>(&object.shape)) {
    way = distance(*wall, ray);
  } else {
    const Pose pose = pose_at(object, time);
    const auto* box = std::get_if<Box>(&object.shape);
    const auto* cylinder = std::get_if<Cylinder>(&object.shape);
    const double reach = box != nullptr
                             ? box->size.squaredNorm() / 4
                             : cylinder->radius * cylinder->radius + cylinder->height * cylinder->height / 4;
    if (passes(ray, pose.translation(), reach)) return;
    const Ray local = transform(pose.inverse(), ray);
    way = box != nullptr ? distance(*box, local) : distance(*cylinder, local);
  }
  if (way < nearest.distance) nearest = {way, object.reflectivity};
}

}  // namespace lidard::sim
