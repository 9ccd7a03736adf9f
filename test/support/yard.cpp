// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/yard.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "test/sim/world/units.h"

namespace lidard::sim {
namespace {

constexpr double lidar_height = 2.0;  // m
constexpr double lidar_noise = 0.02;  // m
constexpr std::size_t output_beams = 720;
constexpr double output_range_max = 60;  // m, the yard's corners are 32 m away
constexpr double way_step = 0.2;         // m
constexpr int blocks = 14;
constexpr int slabs = 4;
constexpr Span revolution = std::chrono::milliseconds(100);

Object box_at(const Eigen::Vector3d& center, const Eigen::Vector3d& size, double yaw) {
  Object box;
  box.shape = Box{size};
  box.pose = make_pose(center, {0, 0, yaw});
  return box;
}

void add_walls(Yard& yard) {
  const Eigen::Vector2d corners[] = {{-25, -20}, {25, -20}, {25, 20}, {-25, 20}};
  for (int i = 0; i < 4; ++i) {
    Object wall;
    wall.shape = Wall{corners[i], corners[(i + 1) % 4], 0, 4};
    yard.objects.push_back(wall);
  }
}

/// A place for something of that radius, clear of the vehicle.
Eigen::Vector2d free_place(Rng& rng, double radius) {
  for (;;) {
    const Eigen::Vector2d at((rng.uniform() - 0.5) * 48, (rng.uniform() - 0.5) * 38);
    if ((at - Eigen::Vector2d(0.75, 0)).norm() > radius + 2.5) return at;
  }
}

Yard random_yard(Rng& rng) {
  Yard yard;
  add_walls(yard);
  for (int i = 0; i < blocks; ++i) {
    const double length = 0.4 + 2.6 * rng.uniform();
    const double width = 0.4 + 2.6 * rng.uniform();
    const double height = 0.3 + 2.5 * rng.uniform();
    const Eigen::Vector2d at = free_place(rng, std::hypot(length, width) / 2);
    yard.objects.push_back(
        box_at({at.x(), at.y(), height / 2}, {length, width, height}, rng.uniform() * pi_d));
  }
  for (int i = 0; i < slabs; ++i) {
    const double length = 1 + 3 * rng.uniform();
    const double width = 1 + 3 * rng.uniform();
    const double z = 2.2 + 0.8 * rng.uniform();
    const Eigen::Vector2d at = free_place(rng, std::hypot(length, width) / 2);
    yard.objects.push_back(box_at({at.x(), at.y(), z}, {length, width, 0.2}, rng.uniform() * pi_d));
  }
  return yard;
}

Ray beam_of(const YardScene& scene, double angle) {
  const Pose& pose = scene.virtual_pose;
  return {pose.translation(), pose.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0)};
}

double truth_at(const YardScene& scene, double angle) {
  return scene.yard.cast(beam_of(scene, angle), false);
}

bool sees(const YardScene& scene, const Eigen::Vector3d& point) {
  const Eigen::Vector3d way = point - scene.lidar.pose.translation();
  const Ray ray{scene.lidar.pose.translation(), way.normalized()};
  return way.norm() < scene.lidar.range_max && scene.yard.cast(ray, true) > way.norm() - 0.02;
}

/// Nothing is between the lidar and any place of the beam's way.
bool is_visible(const YardScene& scene, double angle, double truth) {
  const Ray beam = beam_of(scene, angle);
  for (double at = truth - 0.01; at > 0; at -= way_step) {
    if (!sees(scene, beam.origin + at * beam.direction)) return false;
  }
  return true;
}

/// A beam of the lidar above the plane meets what the virtual beam meets.
bool is_sampled(const YardScene& scene, double angle, double truth) {
  const Ray beam = beam_of(scene, angle);
  const Eigen::Vector3d way = beam.origin + truth * beam.direction - scene.lidar.pose.translation();
  const double far = way.head<2>().norm();
  const double azimuth = std::atan2(way.y(), way.x());
  for (const double e : scene.lidar.elevations) {
    if (far * std::tan(e) < way.z()) continue;
    const Eigen::Vector3d ray(std::cos(e) * std::cos(azimuth), std::cos(e) * std::sin(azimuth), std::sin(e));
    const double range = scene.yard.cast({scene.lidar.pose.translation(), ray}, true);
    return std::abs(range * std::cos(e) - far) < 0.3;
  }
  return false;
}

/// Error of a range against the truth at the beam and half a beam to either side, whichever fits best.
double best_error(const YardScene& scene, std::size_t beam, double range) {
  double best = range - scene.truth[beam];
  for (const double side : {-0.5, 0.5}) {
    const double truth = truth_at(scene, scene.grid.angle(beam) + side * scene.grid.increment);
    if (std::abs(range - truth) < std::abs(best)) best = range - truth;
  }
  return best;
}

}  // namespace

double Yard::cast(const Ray& ray, bool with_ground) const {
  Hit nearest;
  for (const Object& object : objects) lidard::sim::cast(object, ray, 0, nearest);
  if (!with_ground || !ground) return nearest.distance;
  return std::min(nearest.distance, distance(Ground{0}, ray));
}

std::vector<double> even_rings(std::size_t count, double lowest_deg, double highest_deg) {
  std::vector<double> rings;
  const double step = (highest_deg - lowest_deg) / static_cast<double>(count - 1);
  for (std::size_t i = 0; i < count; ++i)
    rings.push_back((lowest_deg + static_cast<double>(i) * step) * degree);
  return rings;
}

Cloud measure(const Yard& yard, const YardLidar& lidar, Rng& rng) {
  Cloud cloud;
  cloud.frame_id = "lidar";
  cloud.stamp = Stamp{1'700'000'000'000'000'000};
  cloud.rings = static_cast<std::uint16_t>(lidar.elevations.size());
  cloud.complete = true;
  std::vector<CloudPoint> points;
  for (std::size_t c = 0; c < lidar.columns; ++c) {
    const double share = static_cast<double>(c) / static_cast<double>(lidar.columns);
    const double azimuth = share * 2 * pi_d;
    const Span after = span_from_seconds(share * seconds(revolution));
    cloud.columns.push_back({static_cast<std::uint32_t>(points.size()), static_cast<std::uint32_t>(c / 24), 0,
                             0, static_cast<float>(azimuth), cloud.stamp + after});
    const Pose pose = lidar.path ? lidar.path(after) : lidar.pose;
    for (std::size_t r = 0; r < lidar.elevations.size(); ++r) {
      const double e = lidar.elevations[r];
      const double a = -azimuth - (lidar.offsets.empty() ? 0 : lidar.offsets[r]);
      const Eigen::Vector3d in_lidar(std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
      const double error = lidar.noise > 0 ? lidar.noise * rng.gaussian() : 0;
      const double range = yard.cast({pose.translation(), pose.linear() * in_lidar}, true) + error;
      if (!(range < lidar.range_max)) continue;
      const Eigen::Vector3f p = (range * in_lidar).cast<float>();
      points.push_back({p.x(), p.y(), p.z(), static_cast<float>(r), static_cast<std::uint16_t>(r),
                        static_cast<float>(seconds(after))});
    }
  }
  cloud.end = cloud.columns.back().stamp;
  cloud.points_bytes.resize(points.size() * sizeof(CloudPoint));
  std::copy(points.begin(), points.end(), cloud.points());
  return cloud;
}

const std::vector<YardCase>& yard_cases() {
  static const Pose level = make_pose({1.5, 0, 0.5}, {0, 0, 0});
  static const Pose high = make_pose({0, 0, lidar_height}, {0, 0, 0});
  static const Pose pitched = make_pose({1.5, -0.8, 0.9}, {0, 0.57 * degree, 0});
  static const auto rings16 = even_rings(16, -15, 15);
  static const auto rings32 = even_rings(32, -25, 15);
  static const auto rings64 = even_rings(64, -24.8, 2);
  static const std::vector<YardCase> cases = {
      {"16 rings +-15 deg, plane at 0.5 m", rings16, level},
      {"16 rings +-15 deg, plane at the lidar's height", rings16, high},
      {"16 rings +-15 deg, plane at 0.9 m pitched 0.57 deg", rings16, pitched},
      {"32 rings -25..15 deg, plane at 0.5 m", rings32, level},
      {"32 rings -25..15 deg, plane at the lidar's height", rings32, high},
      {"64 rings -24.8..2 deg, plane at 0.5 m", rings64, level}};
  return cases;
}

YardScene make_yard_scene(const YardCase& set_up, std::uint64_t seed) {
  Rng rng(seed);
  YardScene scene;
  scene.yard = random_yard(rng);
  scene.lidar.elevations = set_up.elevations;
  scene.lidar.noise = lidar_noise;
  scene.lidar.pose = make_pose({0, 0, lidar_height}, {0, 0, 0});
  scene.cloud = measure(scene.yard, scene.lidar, rng);
  scene.virtual_pose = set_up.virtual_pose;
  ScanGridSpec spec;
  spec.beams = output_beams;
  spec.range_max = output_range_max;
  scene.grid = *make_grid(spec);
  for (std::size_t beam = 0; beam < scene.grid.beams; ++beam) {
    const double angle = scene.grid.angle(beam);
    scene.truth.push_back(truth_at(scene, angle));
    const double truth = scene.truth.back();
    scene.visible.push_back(is_visible(scene, angle, truth) ? 1 : 0);
    scene.sampled.push_back(scene.visible.back() != 0 && is_sampled(scene, angle, truth) ? 1 : 0);
  }
  return scene;
}

void YardScore::add(const YardScore& other) {
  sampled += other.sampled, sampled_missed += other.sampled_missed;
  beams += other.beams, visible += other.visible, right += other.right, phantom += other.phantom;
  through += other.through, free += other.free, silent += other.silent, hidden_wrong += other.hidden_wrong;
}

YardScore judge_yard(const YardScene& scene, const std::vector<Claim>& claims) {
  YardScore score;
  const double tolerance = std::max(0.05, 4 * scene.lidar.noise);
  score.beams = claims.size();
  for (std::size_t beam = 0; beam < claims.size(); ++beam) {
    const Claim& claim = claims[beam];
    const double error = claim.kind == Claim::hit ? best_error(scene, beam, claim.range) : infinite;
    if (scene.visible[beam] == 0) {
      const bool wrong = claim.kind == Claim::hit ? std::abs(error) > tolerance : claim.kind == Claim::free;
      score.hidden_wrong += wrong ? 1 : 0;
      continue;
    }
    ++score.visible;
    const bool sampled = scene.sampled[beam] != 0;
    score.sampled += sampled ? 1 : 0;
    if (sampled && !(std::abs(error) <= tolerance) && !(error < 0)) ++score.sampled_missed;
    if (claim.kind == Claim::nothing)
      ++score.silent;
    else if (claim.kind == Claim::free)
      ++score.free;
    else if (std::abs(error) <= tolerance)
      ++score.right;
    else
      ++(claim.range < scene.truth[beam] ? score.phantom : score.through);
  }
  return score;
}

std::vector<Claim> banded_claims(const YardScene& scene, double half_height) {
  std::vector<Claim> claims(scene.grid.beams, Claim{Claim::free, 0});
  const Pose virtual_from_cloud = scene.virtual_pose.inverse() * scene.lidar.pose;
  for (std::size_t i = 0; i < scene.cloud.size(); ++i) {
    const CloudPoint& point = scene.cloud.points()[i];
    const Eigen::Vector3d p =
        virtual_from_cloud * Eigen::Vector3d(static_cast<double>(point.x), static_cast<double>(point.y),
                                             static_cast<double>(point.z));
    if (std::abs(p.z()) > half_height) continue;
    Claim& claim = claims[scene.grid.nearest(std::atan2(p.y(), p.x())) % claims.size()];
    const double range = p.head<2>().norm();
    if (claim.kind != Claim::hit || range < claim.range) claim = {Claim::hit, range};
  }
  return claims;
}

std::vector<Claim> cut_claims(const YardScene& scene, Profile profile, GroundModel model) {
  VirtualSettings settings;
  settings.visibility = true;
  settings.how.noise = scene.lidar.noise;
  settings.ground.model = model;
  settings.beams.no_return_free_range = scene.lidar.range_max;
  Virtualizer virtualizer(scene.grid, {}, 1, settings);
  virtualizer.set_cloud(scene.cloud, scene.lidar.pose);
  PlanarScan scan;
  virtualizer.project(0, scene.virtual_pose.inverse() * scene.lidar.pose, {{profile, &scan}});
  return claims_of_scan(scan);
}

}  // namespace lidard::sim
