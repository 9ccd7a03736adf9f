// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/merge_score.h"

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/evidence/placed_scan.h"
#include "test/sim/world/circle.h"
#include "test/sim/world/units.h"
#include "test/sim/world/vehicle_motion.h"

namespace lidard::sim {
namespace {

constexpr double scanner_range_max = 25;  // m
constexpr double veil_spot = 0.1 * degree;
constexpr double longest_unseen = 0.06;  // m
constexpr double sample_step = 0.05;     // m

std::vector<FlatScanner> scanners_of(const MergeCase& set_up) {
  FlatScanner scanner;
  scanner.increment = set_up.source_deg * degree;
  scanner.noise = set_up.noise;
  scanner.spot = set_up.veils ? veil_spot : 0;
  scanner.range_max = scanner_range_max;
  std::vector<FlatScanner> both(2, scanner);
  both[0].at = set_up.diagonal ? Eigen::Vector2d(2.25, 1) : Eigen::Vector2d(0, 1);
  both[0].yaw = pi_d / 4;
  both[1].at = set_up.diagonal ? Eigen::Vector2d(-2.25, -1) : Eigen::Vector2d(0, -1);
  both[1].yaw = set_up.diagonal ? -3 * pi_d / 4 : -pi_d / 4;
  return both;
}

/// m from the vehicle's outline, by its bounding box.
bool is_near_vehicle(const Eigen::Vector2d& p, double reach, bool diagonal) {
  const double front = diagonal ? 2.25 : 0;
  const double rear = diagonal ? -2.25 : -4;
  return p.x() > rear - reach && p.x() < front + reach && std::abs(p.y()) < 1 + reach;
}

FlatWorld random_world(Rng& rng, const MergeCase& set_up) {
  const double clear = set_up.driving ? 0.8 : 0.3;  // of the vehicle, m
  FlatWorld world;
  world.add_box({0, 0}, {15, 10}, 0);
  const Eigen::Vector2d at((rng.uniform() - 0.5) * 16, (rng.uniform() - 0.5) * 8);
  const double yaw = rng.uniform() * 2 * pi_d;
  for (int boxes = 0; boxes < 12;) {
    const Eigen::Vector2d center((rng.uniform() - 0.5) * 29, (rng.uniform() - 0.5) * 19);
    const Eigen::Vector2d half(0.05 + 0.75 * rng.uniform(), 0.05 + 0.75 * rng.uniform());
    const double turn = rng.uniform() * pi_d;
    if (is_near_vehicle(Eigen::Rotation2Dd(-yaw) * (center - at), half.norm() + clear, set_up.diagonal))
      continue;
    world.add_box(center, half, turn);
    ++boxes;
  }
  return world.seen_from(at, yaw);
}

bool any_sees(const MergeScene& scene, const Eigen::Vector2d& point) {
  return std::any_of(scene.scanners.begin(), scene.scanners.end(),
                     [&](const FlatScanner& s) { return s.sees(scene.world, point); });
}

/// True if the way along `angle` from the vehicle to `truth` is seen but for short pieces, and the end too.
bool is_observable(const MergeScene& scene, double angle, double truth) {
  const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
  const auto body = scene.body.crossings({0, 0}, ray);
  const double end = std::min(truth, merge_range_max);
  double known = body.empty() ? 0 : body.back().out;
  for (double r = known; r < end - 0.02; r += sample_step) {
    if (any_sees(scene, r * ray))
      known = r;
    else if (r - known > longest_unseen)
      return false;
  }
  return truth > merge_range_max || any_sees(scene, (truth - 0.02) * ray);
}

/// Sweeps of 60 ms of a vehicle that swings; the second one ends up to 20 ms before the first one, whose end
/// is the output's instant. The world is as the vehicle sees it then.
void drive_through(std::uint64_t seed, Rng& rng, MergeScene& scene) {
  constexpr double sweep_s = 0.06;
  constexpr Stamp start{1'000'000'000'000'000'000};
  const SwingingVehicle vehicle(seed, 2);
  const double end = 1 + 0.5 * rng.uniform();
  const Pose here = to_pose(vehicle.at(end)).inverse();
  const auto place = [&](double time) {
    const Pose p = here * to_pose(vehicle.at(time));
    return Pose2{p.translation().x(), p.translation().y(), std::atan2(p.linear()(1, 0), p.linear()(0, 0))};
  };
  PoseTrack track;
  vehicle.report(track, start, 50, end - 0.3, end + 0.02);
  for (std::size_t s = 0; s < scene.scanners.size(); ++s) {
    const FlatScanner& scanner = scene.scanners[s];
    PlanarScan& scan = scene.scans.emplace_back();
    const double begin = end - sweep_s - (s == 0 ? 0 : 0.02 * rng.uniform());
    const double between = sweep_s / (scanner.field / scanner.increment + 1);
    scanner.measure(
        scene.world, [&](std::size_t i) { return place(begin + static_cast<double>(i) * between); }, rng,
        scan);
    scan.stamp = start + span_from_seconds(begin);
    scan.time_increment = static_cast<float>(between);
    scene.motions.emplace_back().follow({start + span_from_seconds(end), &track}, times_of(scan));
  }
}

template <class TakePoint>
void each_point(const MergeScene& scene, bool deskewed, TakePoint take) {
  for (std::size_t s = 0; s < scene.scans.size(); ++s) {
    const PlanarScan& scan = scene.scans[s];
    const Pose pose = scene.scanners[s].pose();
    for (std::size_t i = 0; i < scan.beams; ++i) {
      if (scan.statuses[i] != BeamStatus::hit) continue;
      const auto r = static_cast<double>(scan.ranges[i]);
      const auto a = static_cast<double>(scan.angle(i));
      Eigen::Vector3d p = pose * Eigen::Vector3d(r * std::cos(a), r * std::sin(a), 0);
      if (deskewed && !scene.motions[s].stands()) p = scene.motions[s].moved(i, p);
      take(Eigen::Vector2d(p.head<2>()));
    }
  }
}

std::vector<Claim> nearest_points(const MergeScene& scene, double offset) {
  std::vector<Claim> claims(scene.grid.beams, Claim{Claim::free, 0});
  each_point(scene, false, [&](const Eigen::Vector2d& p) {
    const double range = p.norm();
    const double at = (std::atan2(p.y(), p.x()) + pi_d) / scene.grid.increment + offset;
    Claim& claim = claims[static_cast<std::size_t>(at) % claims.size()];
    if (range > merge_range_max || (claim.kind == Claim::hit && claim.range <= range)) return;
    claim = {Claim::hit, range};
  });
  return claims;
}

/// Error of a hit against the truth at the beam and half a beam to either side, whichever fits best.
double best_error(const MergeScene& scene, std::size_t beam, double range) {
  double best = range - scene.truth[beam];
  for (const double side : {-0.5, 0.5}) {
    const double truth = scene.world.cast({0, 0}, scene.grid.angle(beam) + side * scene.grid.increment);
    if (std::abs(range - truth) < std::abs(best)) best = range - truth;
  }
  return best;
}

void judge_seen(const MergeScene& scene, double tolerance, std::size_t beam, const Claim& claim,
                MergeScore& score) {
  const double truth = scene.truth[beam];
  ++score.seen;
  if (claim.kind == Claim::nothing) {
    ++score.silent;
  } else if (claim.kind == Claim::free) {
    bool open = truth > merge_range_max - tolerance;
    for (const double side : {-0.5, 0.5}) {
      open |=
          scene.world.cast({0, 0}, scene.grid.angle(beam) + side * scene.grid.increment) > merge_range_max;
    }
    ++(open ? score.right : score.false_free);
  } else if (std::abs(best_error(scene, beam, claim.range)) <= tolerance) {
    ++score.right;
    // Accuracy is that of the beam's own direction, where there is no edge beside it.
    const double error = claim.range - truth;
    if (std::abs(error) <= tolerance) score.errors.push_back(static_cast<float>(error));
  } else {
    ++(claim.range > truth ? score.see_through : score.phantom);
  }
}

}  // namespace

const std::vector<MergeCase>& merge_cases() {
  static const std::vector<MergeCase> cases = {
      {"front corners 0.5 deg -> 1080, 10 mm", false, 0.5, 1080, 0.010, false},
      {"diagonal 0.5 deg -> 1080, 10 mm, veils", true, 0.5, 1080, 0.010, true},
      {"diagonal 0.25 deg -> 1440, 10 mm, veils", true, 0.25, 1440, 0.010, true},
      {"diagonal 1/3 deg -> 720, 15 mm, veils", true, 1.0 / 3, 720, 0.015, true},
      {"diagonal 1 deg -> 1440, 20 mm, veils", true, 1.0, 1440, 0.020, true},
      {"diagonal 0.5 deg -> 1080, 10 mm, veils, driving", true, 0.5, 1080, 0.010, true, true},
      {"diagonal 1 deg -> 1440, 20 mm, veils, driving", true, 1.0, 1440, 0.020, true, true}};
  return cases;
}

void MergeScore::add(const MergeScore& other) {
  seen += other.seen, right += other.right, see_through += other.see_through, phantom += other.phantom;
  false_free += other.false_free, silent += other.silent, unseen += other.unseen;
  unseen_free += other.unseen_free, unseen_wrong += other.unseen_wrong;
  errors.insert(errors.end(), other.errors.begin(), other.errors.end());
}

double MergeScore::rms() const {
  double sum = 0;
  for (const float e : errors) sum += static_cast<double>(e) * static_cast<double>(e);
  return std::sqrt(sum / static_cast<double>(errors.size()));
}

double MergeScore::bias() const {
  double sum = 0;
  for (const float e : errors) sum += static_cast<double>(e);
  return sum / static_cast<double>(errors.size());
}

double MergeScore::p99() const {
  std::vector<float> sizes;
  for (const float e : errors) sizes.push_back(std::fabs(e));
  const auto at = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() * 99 / 100);
  std::nth_element(sizes.begin(), at, sizes.end());
  return static_cast<double>(*at);
}

MergeScene make_scene(const MergeCase& set_up, std::uint64_t seed) {
  Rng rng(seed);
  MergeScene scene;
  scene.world = random_world(rng, set_up);
  scene.scanners = scanners_of(set_up);
  scene.grid = test::full_circle(set_up.beams, merge_range_max);
  scene.body = set_up.diagonal ? Footprint({{-2.25, -1}, {2.25, -1}, {2.25, 1}, {-2.25, 1}})
                               : Footprint({{-4, -1}, {0, -1}, {0, 1}, {-4, 1}});
  if (set_up.driving)
    drive_through(seed, rng, scene);
  else
    for (const FlatScanner& scanner : scene.scanners)
      scanner.measure(scene.world, rng, scene.scans.emplace_back());
  scene.motions.resize(scene.scans.size());
  for (std::size_t beam = 0; beam < scene.grid.beams; ++beam) {
    const double angle = scene.grid.angle(beam);
    scene.truth.push_back(scene.world.cast({0, 0}, angle));
    scene.observable.push_back(is_observable(scene, angle, scene.truth.back()) ? 1 : 0);
  }
  return scene;
}

MergeScore judge(const MergeScene& scene, const MergeCase& set_up, const std::vector<Claim>& claims) {
  MergeScore score;
  const double tolerance = std::max(0.05, 4 * set_up.noise);
  for (std::size_t beam = 0; beam < claims.size(); ++beam) {
    const Claim& claim = claims[beam];
    if (scene.observable[beam] != 0) {
      judge_seen(scene, tolerance, beam, claim, score);
      continue;
    }
    ++score.unseen;
    if (claim.kind == Claim::free && scene.truth[beam] <= merge_range_max - tolerance) ++score.unseen_free;
    if (claim.kind == Claim::hit && std::abs(best_error(scene, beam, claim.range)) > tolerance)
      ++score.unseen_wrong;
  }
  return score;
}

std::vector<Claim> claims_of_scan(const PlanarScan& scan) {
  std::vector<Claim> claims(scan.beams);
  for (std::size_t i = 0; i < scan.beams; ++i) {
    if (scan.statuses[i] == BeamStatus::hit) claims[i] = {Claim::hit, static_cast<double>(scan.ranges[i])};
    if (scan.statuses[i] == BeamStatus::none) claims[i].kind = Claim::free;
  }
  return claims;
}

std::vector<Claim> ancestor_claims(const MergeScene& scene) { return nearest_points(scene, 0); }
std::vector<Claim> rounding_claims(const MergeScene& scene) { return nearest_points(scene, 0.5); }

TruthfulClaims truthful_claims(const MergeScene& scene, const MergeCase& set_up) {
  VisibilitySettings settings;
  settings.noise = std::max(set_up.noise, 0.001);
  SourceSettings source;
  source.noise = settings.noise;
  Visibility visibility(scene.grid, settings, scene.scans.size());
  visibility.set_footprint(scene.body);
  std::vector<PlacedScan> sweeps(scene.scans.size());
  std::vector<const PlacedScan*> newest;
  for (std::size_t s = 0; s < sweeps.size(); ++s) {
    BeamRays rays;
    rays.build(scene.scans[s], scene.scanners[s].pose(), scene.body, {});
    visibility.set_source(s, rays);
    measure(scene.scans[s], rays, source, sweeps[s]);
    transform(rays, scene.motions[s], source.noise, sweeps[s]);
    newest.push_back(&sweeps[s]);
  }
  visibility.compute(newest);
  TruthfulClaims claims;
  PlanarScan scan;
  visibility.encode(Profile::strict, scan, false);
  claims.strict = claims_of_scan(scan);
  visibility.encode(Profile::safety, scan, false);
  claims.safety = claims_of_scan(scan);
  each_point(scene, true, [&](const Eigen::Vector2d& p) {
    // At the very limit the surface between this return and the next one may lie beyond it.
    if (p.norm() > merge_range_max - 0.1) return;
    ++claims.returns;
    const std::size_t beam = scene.grid.nearest(std::atan2(p.y(), p.x()));
    double nearest = infinite;
    for (const std::size_t side : {beam + claims.safety.size() - 1, beam, beam + 1}) {
      const Claim& claim = claims.safety[side % claims.safety.size()];
      if (claim.kind == Claim::hit) nearest = std::min(nearest, claim.range);
    }
    if (nearest > p.norm() + std::max(0.1, 4 * settings.noise)) ++claims.dropped;
  });
  return claims;
}

}  // namespace lidard::sim
