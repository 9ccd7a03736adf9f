// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A simulated vehicle that is parked somewhere, with planar scanners whose mounts are configured wrong.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "core/base/angle.h"
#include "core/mounts/mount_solver.h"

namespace lidard::test {

using Eigen::Vector2d;

struct Wall {
  Vector2d from, to;
  bool is_glass = false;  // seen only where a beam meets it squarely; other beams see what is behind
  double moves = 0;       // m ahead in each frame
  int frames = 1000;      // until it is gone
  double dark = 0;        // 0 to 1, by which a scanner's error for dark surfaces applies
};

/// What a ray meets.
struct Met {
  double range = 1e9, cosine = 1, dark = 0;  // m; of the angle of incidence
};

/// Walls seen from above.
struct Place {
  std::vector<Wall> walls;
  std::function<double(double azimuth)> grass;  // m, what stands in the way of a beam

  void box(const Vector2d& centre, double length, double width, double yaw) {
    box(centre, length, width, yaw, Wall{{0, 0}, {0, 0}});
  }
  /// A box whose sides are like `side`.
  void box(const Vector2d& centre, double length, double width, double yaw, Wall side) {
    const Vector2d u = PlanarPose{0, 0, yaw}.turned({length / 2, 0}),
                   v = PlanarPose{0, 0, yaw}.turned({0, width / 2});
    const Vector2d corners[] = {centre + u + v, centre - u + v, centre - u - v, centre + u - v};
    for (int i = 0; i < 4; ++i) {
      side.from = corners[i], side.to = corners[(i + 1) % 4];
      walls.push_back(side);
    }
  }
  void round(const Vector2d& centre, double radius, int sides) {
    const auto corner = [&](int i) -> Vector2d {
      return centre + PlanarPose{0, 0, two_pi * i / sides}.turned({radius, 0});
    };
    for (int i = 0; i < sides; ++i) walls.push_back({corner(i), corner(i + 1)});
  }
  Met meet(const Vector2d& from, double azimuth, int frame) const {
    const Vector2d ray(std::cos(azimuth), std::sin(azimuth));
    Met nearest;
    if (grass) nearest.range = grass(azimuth);
    for (const Wall& wall : walls) {
      const Vector2d side = wall.to - wall.from, to = wall.from + Vector2d(wall.moves * frame, 0) - from;
      const double across = ray.x() * side.y() - ray.y() * side.x();
      const double range = (to.x() * side.y() - to.y() * side.x()) / across,
                   at = (to.x() * ray.y() - to.y() * ray.x()) / across;
      const bool shows = frame < wall.frames && (!wall.is_glass || std::abs(across) > 0.97 * side.norm());
      if (shows && range > 0 && at >= 0 && at <= 1 && range < nearest.range)
        nearest = {range, std::abs(across) / side.norm(), wall.dark};
    }
    return nearest;
  }
};

/// What is wrong with the ranges of a scanner.
struct Errors {
  double noise = 0.01, offset = 0, bias = 0;  // m; the bias is smooth over 10 degrees
  double step = 0.001;                        // m, of the ranges that it sends
  // m, standard deviations of errors that grow with the range (at 10 m), swing with it (every 2 m), grow with
  // the angle of incidence (at 60 degrees) and are those of dark surfaces.
  double by_range = 0, swing = 0, slant = 0, dark = 0;
  double spot = 0;  // rad, of the beam: across an edge it measures something between
};

/// How wrong a scanner is where.
struct Wrong {
  Errors of;  // its own ones
  double phase = 0, swing_phase = 0;
  double at(const Met& met, double angle) const {
    return of.offset + of.bias * std::sqrt(2.0) * std::sin(angle * 18 + phase) +
           of.by_range * met.range / 10 +
           of.swing * std::sqrt(2.0) * std::sin(pi_d * met.range + swing_phase) +
           of.slant * (1 / std::max(0.2, met.cosine) - 1) + of.dark * met.dark;
  }
};

/// Vehicles parked in places, with mounts that are configured wrong.
struct Trial {
  explicit Trial(unsigned seed) : random(seed) {}
  std::mt19937 random;
  Place place;
  std::vector<PlanarPose> truth;
  std::vector<MountedSensor> sensors;

  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  double normal() { return std::normal_distribution<double>()(random); }
  void make_yard() {
    const double length = between(20, 34), width = between(16, 28);
    place.box({0, 0}, length, width, between(-0.3, 0.3));
    for (int i = 0; i < 12; ++i) {
      const Vector2d centre(between(-length / 2, length / 2), between(-width / 2, width / 2));
      if (centre.norm() > 4) place.box(centre, between(0.4, 3), between(0.4, 3), between(0, 3));
    }
  }
  Wrong wrong_of(Errors errors) {
    for (double* one : {&errors.offset, &errors.by_range, &errors.swing, &errors.slant, &errors.dark})
      *one *= normal();
    return {errors, between(0, two_pi), between(0, two_pi)};
  }
  /// The range along a beam, which is as wide as its spot.
  double measured(const Vector2d& from, double azimuth, int frame, const Wrong& wrong, double angle) {
    Met met = place.meet(from, azimuth, frame);
    if (wrong.of.spot > 0) {
      const double left = place.meet(from, azimuth - wrong.of.spot / 2, frame).range,
                   right = place.meet(from, azimuth + wrong.of.spot / 2, frame).range;
      const double near = std::min({met.range, left, right}), far = std::max({met.range, left, right});
      // Of what lies one behind the other it measures a mixture, of what is far behind the nearer one.
      if (far - near > 0.1) met.range = far - near > 1 ? near : near + (far - near) * between(0.2, 0.8);
    }
    return met.range + wrong.at(met, angle) + wrong.of.noise * normal();
  }
  /// A scanner of 0.5 degrees; `far`: by how much its configured pose is off at most.
  void add(const PlanarPose& at, const Errors& errors = {}, bool upside_down = false, double far = 1,
           double from_deg = -137.5, double to_deg = 137.5) {
    const Wrong wrong = wrong_of(errors);
    StillScans scans;
    PlanarScan scan;
    scan.reset(static_cast<std::size_t>(2 * (to_deg - from_deg)) + 1);
    scan.set_angles(static_cast<float>(from_deg * rad_per_deg), static_cast<float>(0.5 * rad_per_deg));
    for (int frame = 0; frame < 25; ++frame) {
      for (std::size_t i = 0; i < scan.beams; ++i) {
        const double angle = static_cast<double>(scan.angle(i));
        const double range =
            measured({at.x, at.y}, at.yaw + (upside_down ? -angle : angle), frame, wrong, angle);
        if (range > 40)
          scan.set_without_hit(i, BeamStatus::none);
        else
          scan.set_hit(i, static_cast<float>(std::round(range / errors.step) * errors.step));
      }
      scans.add(scan);
    }
    MountedSensor sensor;
    sensor.seen.views = scans.views(Eigen::Matrix3d::Identity());
    find_surfaces(sensor.seen.views[0], sensor.seen.surfaces), sensor.seen.height = 0.35;
    add(at, sensor, far);
  }
  /// A lidar of 16 planes 2 m above the ground; walls are 3 m high, and each laser has errors of its own.
  void add_roof(const PlanarPose& at, const Errors& errors, double far = 1) {
    constexpr int planes = 16, azimuths = 900, frames = 10;
    constexpr double height = 2, wall_height = 3;
    const Wrong common = wrong_of(errors);
    Errors own = errors;
    own.offset /= 2;
    std::vector<Wrong> wrong(planes, common);
    for (Wrong& one : wrong) one.of.offset += own.offset * normal(), one.phase = between(0, two_pi);
    std::vector<std::vector<CloudPoint>> clouds(frames);
    for (int i = 0; i < azimuths; ++i) {
      const double angle = two_pi * (i + 0.25) / azimuths;
      for (int plane = 0; plane < planes; ++plane) {
        const double up = (2 * plane - 15) * rad_per_deg;
        const Met met = place.meet({at.x, at.y}, at.yaw + angle, 0);
        const double top = height + met.range * std::tan(up);
        for (auto& cloud : clouds) {
          double range =
              measured({at.x, at.y}, at.yaw + angle, 0, wrong[static_cast<std::size_t>(plane)], angle) /
              std::cos(up);
          if (top < 0) range = -height / std::sin(up) + errors.noise * normal();
          if (top > wall_height || range > 80) continue;
          range = std::round(range / errors.step) * errors.step;
          CloudPoint point{};
          point.x = static_cast<float>(range * std::cos(up) * std::cos(angle));
          point.y = static_cast<float>(range * std::cos(up) * std::sin(angle));
          point.z = static_cast<float>(range * std::sin(up)), point.ring = static_cast<std::uint16_t>(plane);
          cloud.push_back(point);
        }
      }
    }
    StillScans scans;
    Cloud cloud;
    for (const auto& points : clouds) {
      cloud.points_bytes.resize(points.size() * sizeof(CloudPoint));
      std::copy(points.begin(), points.end(), cloud.points());
      scans.add(cloud);
    }
    MountedSensor sensor;
    sensor.seen.views = scans.views(Eigen::Matrix3d::Identity());
    sensor.seen.surfaces = find_upright(sensor.seen.views), sensor.seen.height = height;
    add(at, sensor, far);
  }
  /// Its configured pose is wrong by 0.5 m and 20 degrees times `far` at most.
  void add(const PlanarPose& at, MountedSensor& sensor, double far) {
    const double direction = between(0, two_pi), away = far * between(0, 0.5);
    sensor.configured = {at.x + away * std::cos(direction), at.y + away * std::sin(direction),
                         at.yaw + far * between(-20, 20) * rad_per_deg};
    truth.push_back(at);
    sensors.push_back(sensor);
  }
  void add_three(const Errors& errors = {}) {
    add({0.5, 1, 0.7}, errors);
    add({0.5, -1, -0.7}, errors);
    add({-3, between(-0.5, 0.5), pi_d + between(-0.3, 0.3)}, errors);
  }
  /// Error of a sensor's pose against the reference, in base_frame: m, m, rad.
  Eigen::Vector3d error(const MountSolution& solution, std::size_t i) const {
    const PlanarPose want = sensors[0].configured * (truth[0].inverse() * truth[i]);
    const PlanarPose& got = solution.sensors[i].pose;
    return {got.x - want.x, got.y - want.y, std::remainder(got.yaw - want.yaw, two_pi)};
  }
};

}  // namespace lidard::test
