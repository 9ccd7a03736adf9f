// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/mount_solver.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>

#include "core/base/angle.h"
#include "core/mounts/surface_match.h"
#include "core/mounts/wall_fit.h"

namespace lidard {
namespace {

using Eigen::Vector2d;

constexpr int starts = 24;
// Starts with about the configured yaw are also tried so far aside, m: rows of equal things fit one thing
// further, too.
constexpr double start_aside_m = 0.6;
// Poses nearer to each other than this are one, m and rad.
constexpr double same_pose_m = 0.1, same_pose_rad = 3 * rad_per_deg;
// A pose where so many of the judged returns are confirmed is right if no other pose comes as near: less
// where it is about as configured than where it is turned or upside down. In a rectangle with one box the
// margin is up to 0.03.
constexpr double least_agreement = 0.9, least_margin = 0.05, least_margin_elsewhere = 0.1;
// Two configured poses are no more wrong than this, m, and per m between them: a sensor that is turned by 20
// degrees sees another one elsewhere. Nearer to the configured yaw than that, rad, a pose is about as
// configured.
constexpr double farthest_start_m = 1.5, farther_by_distance = 0.5,
                 about_as_configured_rad = 45 * rad_per_deg;
// Across a corridor, which cannot show more, a configured pose is no more wrong than this, m.
constexpr double configured_wrong_m = 0.5;
// A direction is a turn if its part of turning exceeds this, and a shift else.
constexpr double turning_part = 0.3;
constexpr std::size_t least_judged = 60;
// Returns that count against a pose beside those that do, so that few returns must agree better.
constexpr double against_a_pose = 4;
constexpr std::size_t coarse_surfaces = 80;
// Surfaces of a wall are joined within these, m, one after the other.
constexpr std::array<double, 3> wall_gates{0.12, 0.08, 0.06};
// Steps of the bias that surfaces may have in common for their beams, m, and their size in what data sheets
// say and tests of scanners find.
constexpr std::array<double, 9> biases{0.0003, 0.0006, 0.001, 0.0015, 0.0025, 0.004, 0.006, 0.010, 0.015};
constexpr double usual_bias = 0.005;
// Biases that change slowly along the walls hide in their fit.
constexpr double hidden_bias = 1.2;
// What is known no better than this, m and rad, is not determined.
constexpr double worst_m = 0.01, worst_rad = 0.1 * rad_per_deg;
// By how much a configured pose may be wrong, standard deviation.
constexpr double configured_m = 0.3, configured_rad = 10 * rad_per_deg;

/// The longest surfaces, which suffice for the coarse steps.
std::vector<Surface> longest(std::vector<Surface> surfaces) {
  if (surfaces.size() > coarse_surfaces) {
    std::nth_element(surfaces.begin(), surfaces.begin() + coarse_surfaces, surfaces.end(),
                     [](const Surface& a, const Surface& b) { return a.length() > b.length(); });
    surfaces.resize(coarse_surfaces);
  }
  return surfaces;
}

bool is_same(const PlanarPose& a, const PlanarPose& b) {
  return a.distance_to(b) < same_pose_m && a.angle_to(b) < same_pose_rad;
}

bool is_about_as(const PlanarPose& configured, const PlanarPose& pose) {
  return pose.angle_to(configured) < about_as_configured_rad;
}

/// A pose of one sensor in the frame of another, and how far the returns of both agree there.
struct Candidate {
  PlanarPose pose;
  Agreement agreement;
  // Farther from the configured position than a tape errs, along a corridor: nothing to find, but a rival.
  bool is_far;

  bool is_judged() const { return agreement.judged() >= least_judged; }
  bool agrees() const {
    return is_judged() && static_cast<double>(agreement.confirmed) >=
                              least_agreement * (static_cast<double>(agreement.judged()) + against_a_pose);
  }
};

/// Share of the points of surfaces of `b` that lie on one of `a`: for sensors of which none sees through a
/// plane.
Agreement surfaces_met(const Surroundings& a, const Surroundings& b, const PlanarPose& a_from_b) {
  Agreement result;
  for (const Surface& surface : b.surfaces) {
    const Vector2d normal = a_from_b.turned(surface.normal);
    for (const Vector2d& point : surface.points) {
      const Vector2d q = a_from_b * point;
      const bool met = std::any_of(a.surfaces.begin(), a.surfaces.end(), [&](const Surface& line) {
        const double s = line.along.dot(q - line.middle);
        return std::abs(line.normal.dot(q - line.middle)) < 0.05 && line.normal.dot(normal) > 0.98 &&
               s > line.from && s < line.to;
      });
      met ? ++result.confirmed : ++result.refuted;
    }
  }
  return result;
}

using Candidates = std::vector<Candidate>;

/// Poses of `b` in the frame of `a`, the best first.
Candidates find_candidates(const Surroundings& a, const Surroundings& b, const PlanarPose& configured) {
  Candidates candidates;
  const std::vector<Surface> lines = longest(a.surfaces), others = longest(b.surfaces);
  const double farthest = farthest_start_m + farther_by_distance * std::hypot(configured.x, configured.y);
  const auto try_start = [&](double aside_x, double aside_y, double turn) {
    const PlanarPose start{configured.x + aside_x, configured.y + aside_y,
                           std::remainder(configured.yaw + turn, two_pi)};
    const PlanarPose pose = match_surfaces(lines, others, start);
    const bool is_far = pose.distance_to(configured) > farthest;
    if (is_far && pose.angle_to(configured) > about_as_configured_rad) return;
    if (std::any_of(candidates.begin(), candidates.end(),
                    [&](const Candidate& known) { return is_same(known.pose, pose); }))
      return;
    const bool has_planar = a.is_planar() || b.is_planar();
    candidates.push_back({pose, has_planar ? agreement(a, b, pose) : surfaces_met(a, b, pose), is_far});
  };
  for (int i = 0; i < starts; ++i) try_start(0, 0, two_pi * i / starts);
  for (const int i : {-1, 0, 1}) {
    for (const double aside : {-start_aside_m, start_aside_m})
      try_start(aside, 0, two_pi * i / starts), try_start(0, aside, two_pi * i / starts);
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& x, const Candidate& y) {
    if (x.is_judged() != y.is_judged()) return x.is_judged();
    return x.agreement.share() > y.agreement.share();
  });
  return candidates;
}

/// The agreement of a candidate, 0 if there is none of this rank or it is not judged.
double share_of(const Candidates& candidates, std::size_t rank) {
  if (rank >= candidates.size() || !candidates[rank].is_judged()) return 0;
  return candidates[rank].agreement.share();
}

/// The direction in which alone surfaces that both see let `b` slide; nothing: there is none, or another one.
std::optional<Vector2d> slide_of(const Surroundings& a, const Surroundings& b, const PlanarPose& pose) {
  std::vector<WallFit::Sensor> both(2);
  both[0].seen = &a, both[0].is_fixed = true, both[1].seen = &b, both[1].pose = pose;
  WallFit fit(both);
  if (!fit.find_walls(wall_gates[0])) return std::nullopt;
  fit.find_held();
  const std::vector<Eigen::Vector3d>& held = fit.sensors()[1].held;
  if (held.size() != 1 || std::abs(held[0][2]) > turning_part) return std::nullopt;
  return held[0].head<2>().normalized();
}

/// In a corridor, which looks the same farther along, turned by half and upside down: the candidate about as
/// configured, if there is but one across the corridor, at the configured position along it. `candidates`:
/// the best first.
std::optional<Candidate> candidate_across(const Surroundings& a, const Surroundings& b,
                                          const PlanarPose& configured, const Candidates& candidates) {
  const auto best = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& one) {
    return one.agrees() && is_about_as(configured, one.pose);
  });
  if (best == candidates.end()) return std::nullopt;
  const std::optional<Vector2d> slide = slide_of(a, b, best->pose);
  if (!slide) return std::nullopt;
  const auto apart = [&](const PlanarPose& x, const PlanarPose& y) {
    return std::abs(slide->x() * (y.y - x.y) - slide->y() * (y.x - x.x));
  };
  if (apart(best->pose, configured) >
      configured_wrong_m + farther_by_distance * std::hypot(configured.x, configured.y))
    return std::nullopt;
  const bool is_rivalled = std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& other) {
    return other.agrees() && other.agreement.share() > best->agreement.share() - least_margin &&
           is_about_as(configured, other.pose) &&
           (apart(other.pose, best->pose) > same_pose_m || other.pose.angle_to(best->pose) > same_pose_rad);
  });
  if (is_rivalled) return std::nullopt;
  Candidate across = *best;
  const double along = slide->dot(configured.position() - across.pose.position());
  across.pose.x += along * slide->x(), across.pose.y += along * slide->y();
  return across;
}

/// What a pair of sensors says of the pose of the second.
struct Pair {
  std::size_t first, second;
  PlanarPose pose;
  double margin = 0;  // of the agreement above that of the next candidate
  bool is_sure = false, is_ambiguous = false, is_mirrored = false;
  Agreement as_configured{}, as_found{};
};

Pair find_pair(const std::vector<MountedSensor>& sensors, std::size_t first, std::size_t second) {
  const Surroundings &a = sensors[first].seen, &b = sensors[second].seen;
  const PlanarPose configured = sensors[first].configured.inverse() * sensors[second].configured;
  Pair pair{first, second, configured};
  pair.as_configured = agreement(a, b, configured);
  const Candidates upright = find_candidates(a, b, configured);
  const Candidates upside_down = b.is_planar() ? find_candidates(a, mirrored(b), configured) : Candidates();
  pair.is_mirrored = share_of(upside_down, 0) > share_of(upright, 0);
  const Candidates &candidates = pair.is_mirrored ? upside_down : upright,
                   &others = pair.is_mirrored ? upright : upside_down;
  if (candidates.empty() || !candidates[0].is_judged()) return pair;
  const Candidate& best = candidates[0];
  pair.pose = best.pose, pair.as_found = best.agreement;
  pair.margin = best.agreement.share() - std::max(share_of(candidates, 1), share_of(others, 0));
  const double turned = pair.pose.angle_to(configured);
  const bool elsewhere = pair.is_mirrored || turned > about_as_configured_rad;
  // A mount may be configured turned by half, but not by a quarter.
  const bool quarter = turned > about_as_configured_rad && turned < pi_d - about_as_configured_rad;
  pair.is_sure = best.agrees() && !best.is_far && !quarter &&
                 pair.margin >= (elsewhere ? least_margin_elsewhere : least_margin);
  if (!pair.is_sure) {
    if (const auto across = candidate_across(a, b, configured, upright)) {
      pair.pose = across->pose, pair.as_found = across->agreement;
      pair.is_sure = true, pair.is_mirrored = false, pair.margin = 0;
    }
  }
  pair.is_ambiguous = best.agrees() && !pair.is_sure;
  return pair;
}

std::vector<Pair> find_pairs(const std::vector<MountedSensor>& sensors) {
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < sensors.size(); ++a) {
    for (std::size_t b = 0; b < sensors.size(); ++b) {
      const bool is_planar = sensors[a].seen.is_planar(),
                 are_alike = is_planar == sensors[b].seen.is_planar();
      // A multi-plane lidar is never upside down, so it stands first.
      if (are_alike ? a < b : !is_planar) pairs.push_back(find_pair(sensors, a, b));
    }
  }
  return pairs;
}

/// Connects sensors to the reference, pair by pair, the surest first: their poses and verdicts. Returns the
/// reference and those connected to it.
std::vector<std::size_t> connect(const std::vector<MountedSensor>& sensors, const std::vector<Pair>& pairs,
                                 std::size_t reference, std::vector<MountEstimate>& estimates) {
  std::vector<std::size_t> connected{reference};
  const auto is_connected = [&](std::size_t i) {
    return std::find(connected.begin(), connected.end(), i) != connected.end();
  };
  /// Whether the sensor of a pair that is not connected yet hangs the other way up than the reference.
  const auto is_mirrored_by = [&](const Pair& pair) {
    return estimates[is_connected(pair.first) ? pair.first : pair.second].is_mirrored != pair.is_mirrored;
  };
  while (true) {
    const Pair* best = nullptr;
    for (const Pair& pair : pairs) {
      if (!pair.is_sure || is_connected(pair.first) == is_connected(pair.second)) continue;
      const std::size_t next = is_connected(pair.first) ? pair.second : pair.first;
      if (is_mirrored_by(pair) && !sensors[next].seen.is_planar())
        continue;  // the reference hangs upside down
      if (best == nullptr || pair.margin > best->margin) best = &pair;
    }
    if (best == nullptr) break;
    const bool forward = is_connected(best->first);
    const MountEstimate& known = estimates[forward ? best->first : best->second];
    const std::size_t added = forward ? best->second : best->first;
    // With M for the mirror: T M inverted is M inv(T), that is (M inv(T) M) M; M T is (M T M) M.
    PlanarPose step = forward ? best->pose : best->pose.inverse();
    if ((!forward && best->is_mirrored) != known.is_mirrored) step = {step.x, -step.y, -step.yaw};
    MountEstimate& estimate = estimates[added];
    estimate.verdict = MountVerdict::found;
    estimate.pose = known.pose * step;
    estimate.is_mirrored = is_mirrored_by(*best);
    estimate.as_configured = best->as_configured, estimate.as_found = best->as_found;
    connected.push_back(added);
  }
  for (const Pair& pair : pairs) {
    for (const std::size_t i : {pair.first, pair.second}) {
      if (!is_connected(i) && pair.is_ambiguous) estimates[i].verdict = MountVerdict::ambiguous;
    }
  }
  return connected;
}

FreeDirection direction_of(const WallFit::Sensor& sensor, const Eigen::Vector3d& held) {
  FreeDirection free;
  free.turn = std::abs(held[2]) > turning_part;
  if (free.turn) {
    // A shift beside the turn moves the point about which it turns.
    const double rate = held[2] / sensor.lever;
    free.about = sensor.centre + Vector2d(-held[1], held[0]) / rate;
  } else {
    free.shift = held.head<2>().normalized();
  }
  return free;
}

/// Moves the pose along the held directions as near to where it is configured as these allow.
void keep_configured(WallFit::Sensor& sensor, const PlanarPose& configured) {
  const Eigen::Vector3d weights(1, 1, configured_m / configured_rad);
  for (int round = 0; round < 5 && !sensor.held.empty(); ++round) {
    const PlanarPose& at = sensor.pose;
    const Eigen::Vector3d off(configured.x - at.x, configured.y - at.y,
                              std::remainder(configured.yaw - at.yaw, two_pi));
    Eigen::MatrixXd moves(3, sensor.held.size());
    for (std::size_t i = 0; i < sensor.held.size(); ++i)
      moves.col(static_cast<Eigen::Index>(i)) = weights.cwiseProduct(sensor.pose_change(sensor.held[i]));
    const Eigen::VectorXd far = moves.colPivHouseholderQr().solve(weights.cwiseProduct(off));
    Eigen::Vector3d part = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < sensor.held.size(); ++i)
      part += far[static_cast<Eigen::Index>(i)] * sensor.held[i];
    sensor.move(part);
  }
}

/// The bias that the residuals show. A few walls show it badly, so that it is the mean of what may be.
WallFit::Bias learn_bias(WallFit& fit) {
  WallFit::Bias bias{0.003, 0.003};
  for (double WallFit::Bias::*const part :
       {&WallFit::Bias::turning, &WallFit::Bias::across, &WallFit::Bias::turning, &WallFit::Bias::across}) {
    std::array<double, biases.size()> unlikely{};
    for (std::size_t i = 0; i < biases.size(); ++i) {
      bias.*part = biases[i];
      fit.refine(bias, 2);
      unlikely[i] = fit.unlikeliness();
    }
    const double least = *std::min_element(unlikely.begin(), unlikely.end());
    double sum = 0, square = 0;
    for (std::size_t i = 0; i < biases.size(); ++i) {
      const double likely =
          std::exp((least - unlikely[i]) / 2 - biases[i] * biases[i] / (2 * usual_bias * usual_bias));
      sum += likely, square += likely * biases[i] * biases[i];
    }
    bias.*part = hidden_bias * std::sqrt(square / sum);
  }
  return bias;
}

void describe(const WallFit& fit, std::size_t index, const PlanarPose& configured, MountEstimate& estimate) {
  const WallFit::Sensor& sensor = fit.sensors()[index];
  estimate.pose = sensor.pose;
  estimate.surfaces = sensor.shared;
  if (sensor.shared == 0) {
    estimate.verdict = MountVerdict::unconnected;
    estimate.pose = configured;
    return;
  }
  estimate.covariance = fit.covariance(index);
  estimate.range_offset = fit.offset_of(index);
  const auto sigma = [&](int c) { return std::sqrt(estimate.covariance(c, c)); };
  if (sigma(0) > worst_m || sigma(1) > worst_m || sigma(2) > worst_rad) {
    // x, y and yaw depend on each other: all or none of them is changed.
    estimate.verdict = MountVerdict::uncertain;
    estimate.pose = configured;
    return;
  }
  // In a held direction the pose is as wrong as it is configured, and so is each of x, y and yaw that the
  // direction moves.
  for (const Eigen::Vector3d& held : sensor.held) {
    estimate.free.push_back(direction_of(sensor, held));
    const Eigen::Vector3d move = configured_m * sensor.pose_change(held);
    estimate.covariance += move * move.transpose();
  }
  estimate.determined = {sigma(0) < worst_m, sigma(1) < worst_m, sigma(2) < worst_rad};
}

}  // namespace

MountSolution solve_mounts(const std::vector<MountedSensor>& sensors, std::size_t reference) {
  MountSolution solution;
  for (const MountedSensor& sensor : sensors) {
    solution.sensors.emplace_back();
    solution.sensors.back().pose = sensor.configured;
  }
  solution.sensors[reference].verdict = MountVerdict::reference;
  const auto connected = connect(sensors, find_pairs(sensors), reference, solution.sensors);
  if (connected.size() < 2) return solution;

  std::deque<Surroundings> seen;  // as if no sensor hung upside down
  std::vector<WallFit::Sensor> unknown;
  for (const std::size_t i : connected) {
    seen.push_back(solution.sensors[i].is_mirrored ? mirrored(sensors[i].seen) : sensors[i].seen);
    WallFit::Sensor sensor;
    sensor.seen = &seen.back(), sensor.pose = solution.sensors[i].pose, sensor.is_fixed = i == reference;
    unknown.push_back(sensor);
  }
  WallFit fit(unknown);
  for (const double gate : wall_gates) {
    if (!fit.find_walls(gate)) return solution;
    fit.find_held();
    for (std::size_t i = 1; i < connected.size(); ++i)
      keep_configured(fit.sensor(i), sensors[connected[i]].configured);
    fit.refine({0.003, 0.003}, 4);
  }
  const WallFit::Bias bias = learn_bias(fit);
  fit.refine(bias, 3);
  solution.bias = bias.across, solution.chi_square = fit.chi_square();
  for (std::size_t i = 1; i < connected.size(); ++i)
    describe(fit, i, sensors[connected[i]].configured, solution.sensors[connected[i]]);
  return solution;
}

}  // namespace lidard
