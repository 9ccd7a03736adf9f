// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/hidden.h"

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "test/sim/world/circle.h"
#include "test/sim/world/units.h"

namespace lidard::sim {
namespace {

constexpr double mast_height = 2;     // m, of the lidar
constexpr double scanner_reach = 25;  // m
constexpr int posts = 9;
// Rays over the width of a beam by which its truth is found.
constexpr int rays_of_beam = 5;

Footprint body() { return Footprint({{-4, -1}, {0, -1}, {0, 1}, {-4, 1}}); }

std::vector<FlatScanner> scanners_of(const HidingCase& set_up) {
  FlatScanner scanner;
  scanner.increment = set_up.source_deg * degree;
  scanner.noise = set_up.noise;
  scanner.range_max = scanner_reach;
  std::vector<FlatScanner> both(2, scanner);
  both[0].at = {0, 1}, both[0].yaw = pi_d / 4;
  both[1].at = {0, -1}, both[1].yaw = -pi_d / 4;
  return both;
}

/// The places that look at the yard.
std::vector<Eigen::Vector2d> eyes_of(const HidingCase& set_up) {
  if (set_up.from_cloud) return {{0, 0}};
  return {{0, 1}, {0, -1}};
}

/// Thin walls along the way from `eye` to `thing` that hide all of it.
Thing rod_before(const Thing& thing, const Eigen::Vector2d& eye, double share) {
  const Eigen::Vector2d way = thing.at - eye;
  const double reach = thing.half.norm();
  const double half = share * reach * 1.1 + 0.005;
  return {eye + share * way, {0.01, half}, std::atan2(way.y(), way.x()), thing.height};
}

void add_things(Rng& rng, const HidingCase& set_up, std::vector<Thing>& things) {
  const double size = 0.02 + 0.1 * rng.uniform();  // half of a side, m
  const Eigen::Vector2d place(set_up.at.x(), set_up.at.y());
  Eigen::Vector2d at;
  double clear = 0;
  do {
    const double range = 0.8 + (set_up.range_max - 1) * rng.uniform();
    const double angle = (rng.uniform() * 2 - 1) * pi_d;
    at = place + range * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    clear = infinite;
    for (const Eigen::Vector2d& eye : eyes_of(set_up)) clear = std::min(clear, (at - eye).norm());
  } while (clear < 2 || at.x() < 0.7);
  const double yaw = rng.uniform() * pi_d;
  const Thing post{at, {size, size * (0.3 + 0.7 * rng.uniform())}, yaw, 2};
  const Eigen::Vector2d along(std::cos(yaw), std::sin(yaw));
  switch (set_up.hiding) {
    case Hiding::posts:
      things.push_back(post);
      break;
    case Hiding::behind_rods:
      things.push_back(post);
      for (const Eigen::Vector2d& eye : eyes_of(set_up))
        things.push_back(rod_before(post, eye, 0.45 + 0.4 * rng.uniform()));
      break;
    case Hiding::combs:
      for (int k = -2; k <= 2; ++k) things.push_back({at + 4.0 * k * size * along, {size, size}, yaw, 2});
      break;
    case Hiding::slits:
      for (const int side : {-1, 1})
        things.push_back({at + side * (0.5 + size) * along, {0.5, 0.02 + 0.1 * rng.uniform()}, yaw, 2});
      break;
    case Hiding::low:
      things.push_back({at, {size + 0.2 * rng.uniform(), size}, yaw, set_up.at.z() + 0.3 * rng.uniform()});
      break;
    case Hiding::low_walls: {
      const double askew = rng.uniform() < 0.5 ? 0 : 0.3 * (rng.uniform() - 0.5);
      things.push_back({at,
                        {0.05, 0.3 + 1.5 * rng.uniform()},
                        std::atan2(at.y(), at.x()) + askew,
                        set_up.at.z() + 0.3 * rng.uniform()});
      break;
    }
  }
}

Object object_of(const Thing& thing) {
  Object box;
  box.shape = Box{{2 * thing.half.x(), 2 * thing.half.y(), thing.height}};
  box.pose = make_pose({thing.at.x(), thing.at.y(), thing.height / 2}, {0, 0, thing.yaw});
  return box;
}

Yard yard_of(const HidingScene& scene) {
  Yard yard;
  for (const Thing& thing : scene.things) yard.objects.push_back(object_of(thing));
  return yard;
}

void merge(const HidingCase& set_up, const FlatWorld& world, Rng& rng, HidingScene& scene) {
  MergeSettings settings;
  settings.visibility = true;
  settings.how.noise = std::max(set_up.noise, 0.001);
  const auto scanners = scanners_of(set_up);
  settings.source.noise = settings.how.noise;
  Merger merger(test::full_circle(set_up.beams, set_up.range_max), {}, scanners.size(), settings);
  const Pose output = make_pose({set_up.at.x(), set_up.at.y(), 0}, {0, 0, 0}).inverse();
  merger.set_footprint(body().transformed(output));
  PlanarScan scan;
  // In the second sweep a rod that one beam meets is no drop.
  for (const Stamp at : {Stamp{1'699'999'999'950'000'000}, Stamp{1'700'000'000'000'000'000}}) {
    for (std::size_t s = 0; s < scanners.size(); ++s) {
      scanners[s].measure(world, rng, scan);
      scan.stamp = at;
      merger.add(s, scan, output * scanners[s].pose());
    }
  }
  PlanarScan strict, safety;
  merger.merge({Stamp{1'700'000'000'100'000'000}, nullptr}, std::vector<char>(scanners.size(), 1),
               {{Profile::strict, &strict}, {Profile::safety, &safety}}, nullptr);
  scene.strict = claims_of_scan(strict);
  scene.safety = claims_of_scan(safety);
}

void cut(const HidingCase& set_up, const Yard& yard, Rng& rng, HidingScene& scene) {
  YardLidar lidar;
  lidar.elevations = even_rings(set_up.rings, -15, 15);
  lidar.columns = static_cast<std::size_t>(std::lround(360 / set_up.source_deg));
  lidar.noise = set_up.noise;
  lidar.pose = make_pose({0, 0, mast_height}, {0, 0, 0});
  const Cloud cloud = measure(yard, lidar, rng);
  VirtualSettings settings;
  settings.visibility = true;
  settings.how.noise = std::max(set_up.noise, 0.001);
  settings.ground.model = GroundModel::plane;
  settings.beams.no_return_free_range = lidar.range_max;
  Virtualizer virtualizer(test::full_circle(set_up.beams, set_up.range_max), {}, 1, settings);
  virtualizer.set_cloud(cloud, lidar.pose);
  PlanarScan strict, safety;
  virtualizer.project(0, make_pose(set_up.at, {0, 0, 0}).inverse() * lidar.pose,
                      {{Profile::strict, &strict}, {Profile::safety, &safety}});
  scene.strict = claims_of_scan(strict);
  scene.safety = claims_of_scan(safety);
}

/// Nothing is between some sensor and the point, and a beam can reach it.
bool any_sees(const HidingCase& set_up, const std::vector<FlatScanner>& scanners, const FlatWorld& world,
              const Yard& yard, const Eigen::Vector2d& point) {
  if (!set_up.from_cloud) {
    return std::any_of(scanners.begin(), scanners.end(),
                       [&](const FlatScanner& s) { return s.sees(world, point); });
  }
  const Eigen::Vector3d way(point.x(), point.y(), set_up.at.z() - mast_height);
  const double elevation = std::atan2(way.z(), point.norm());
  const Ray ray{{0, 0, mast_height}, way.normalized()};
  return std::abs(elevation) < 15 * degree && yard.cast(ray, true) > way.norm();
}

/// m along a ray from `at` to where it leaves the thing that it meets at `range`.
double end_of_thing(const HidingScene& scene, const Eigen::Vector2d& at, double angle, double range) {
  const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
  double end = range;
  for (const Thing& thing : scene.things) {
    const Eigen::Rotation2Dd into(-thing.yaw);
    const Eigen::Vector2d from = into * (at - thing.at), along = into * ray;
    double begin = -infinite, leave = infinite;
    for (const int axis : {0, 1}) {
      const double a = (-thing.half[axis] - from[axis]) / along[axis];
      const double b = (thing.half[axis] - from[axis]) / along[axis];
      begin = std::max(begin, std::min(a, b));
      leave = std::min(leave, std::max(a, b));
    }
    if (begin <= leave && std::abs(begin - range) < 1e-6) end = std::max(end, leave);
  }
  return end;
}

void find_truth(const HidingCase& set_up, const FlatWorld& world, const Yard& yard, HidingScene& scene) {
  const ScanGrid grid = test::full_circle(set_up.beams, set_up.range_max);
  const auto scanners = scanners_of(set_up);
  const Eigen::Vector2d at = set_up.at.head<2>();
  for (std::size_t beam = 0; beam < grid.beams; ++beam) {
    double nearest = infinite, farthest = 0;
    for (int k = 0; k < rays_of_beam; ++k) {
      const double angle = grid.angle(beam) + grid.increment * (k / (rays_of_beam - 1.0) - 0.5);
      const double range = world.cast(at, angle);
      nearest = std::min(nearest, range);
      farthest = std::max(farthest, range < infinite ? end_of_thing(scene, at, angle, range) : infinite);
    }
    scene.nearest.push_back(nearest);
    scene.farthest.push_back(farthest);
    const Eigen::Vector2d ray(std::cos(grid.angle(beam)), std::sin(grid.angle(beam)));
    const Footprint vehicle = body();
    bool open = nearest > set_up.range_max;
    for (double r = 0.05; open && r < set_up.range_max; r += 0.05) {
      const Eigen::Vector2d point = at + r * ray;
      open =
          (!set_up.from_cloud && vehicle.contains(point)) || any_sees(set_up, scanners, world, yard, point);
    }
    scene.open.push_back(open ? 1 : 0);
  }
}

}  // namespace

const std::vector<HidingCase>& hiding_cases() {
  static const Eigen::Vector3d front(0, 0, 0.35), rear(-4, 0, 0.35), ahead(6, 0, 0.5), side(3, 2, 0.8);
  static const std::vector<HidingCase> cases = {
      {"merged, posts", Hiding::posts, false, 0.5, 720, 0.01, front, 8},
      {"merged, posts, 0.25 deg", Hiding::posts, false, 0.25, 1440, 0, front, 15},
      {"merged, posts, from the rear", Hiding::posts, false, 1.0 / 3, 1080, 0.02, rear, 12},
      {"merged, behind rods", Hiding::behind_rods, false, 0.5, 720, 0.01, front, 8},
      {"merged, behind rods, 0.25 deg", Hiding::behind_rods, false, 0.25, 1440, 0, front, 15},
      {"merged, combs", Hiding::combs, false, 0.5, 720, 0.01, front, 8},
      {"merged, slits", Hiding::slits, false, 1.0 / 3, 1080, 0.01, front, 10},
      {"virtual, posts", Hiding::posts, true, 0.2, 720, 0.01, ahead, 4},
      {"virtual, posts, from the side", Hiding::posts, true, 0.2, 720, 0.02, side, 8},
      {"virtual, posts, 32 rings", Hiding::posts, true, 0.2, 1080, 0, ahead, 6, 32},
      {"virtual, behind rods", Hiding::behind_rods, true, 0.2, 720, 0.01, ahead, 4},
      {"virtual, combs", Hiding::combs, true, 0.2, 720, 0.01, ahead, 4},
      {"virtual, slits", Hiding::slits, true, 0.2, 720, 0.01, ahead, 6},
      {"virtual, low boxes", Hiding::low, true, 0.2, 720, 0.01, ahead, 4},
      {"virtual, low walls", Hiding::low_walls, true, 0.2, 720, 0.01, ahead, 12}};
  return cases;
}

HidingScene make_hiding_scene(const HidingCase& set_up, std::uint64_t seed) {
  Rng rng(seed);
  HidingScene scene;
  for (int i = 0; i < posts; ++i) add_things(rng, set_up, scene.things);
  FlatWorld world;
  for (const Thing& thing : scene.things) world.add_box(thing.at, thing.half, thing.yaw);
  const Yard yard = yard_of(scene);
  if (set_up.from_cloud)
    cut(set_up, yard, rng, scene);
  else
    merge(set_up, world, rng, scene);
  find_truth(set_up, world, yard, scene);
  return scene;
}

void HidingScore::add(const HidingScore& other) {
  blocked += other.blocked, right += other.right, falsely_free += other.falsely_free;
  seen_through += other.seen_through, phantom += other.phantom, unknown += other.unknown;
  open += other.open, open_free += other.open_free, open_hit += other.open_hit;
}

HidingScore judge_hiding(const HidingCase& set_up, const HidingScene& scene,
                         const std::vector<Claim>& claims) {
  HidingScore score;
  const double tolerance = std::max(0.05, 4 * set_up.noise);
  for (std::size_t beam = 0; beam < claims.size(); ++beam) {
    const Claim& claim = claims[beam];
    if (scene.open[beam] != 0) {
      ++score.open;
      score.open_free += claim.kind == Claim::free ? 1 : 0;
      score.open_hit += claim.kind == Claim::hit ? 1 : 0;
    }
    if (scene.farthest[beam] > set_up.range_max) continue;
    ++score.blocked;
    if (claim.kind == Claim::nothing)
      ++score.unknown;
    else if (claim.kind == Claim::free)
      ++score.falsely_free;
    else if (claim.range > scene.farthest[beam] + tolerance)
      ++score.seen_through;
    else
      ++(claim.range < scene.nearest[beam] - tolerance ? score.phantom : score.right);
  }
  return score;
}

}  // namespace lidard::sim
