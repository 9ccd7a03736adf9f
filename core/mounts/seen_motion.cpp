// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/seen_motion.h"

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "core/mounts/surface_match.h"
#include "core/mounts/surroundings.h"

namespace lidard {
namespace {

constexpr double least_way = 0.05, least_turn = 0.5 * rad_per_deg;  // m, rad: what counts as a move
constexpr double least_chi_square = 50;                             // of a move against its noise
constexpr std::size_t fewest_matched = 4;
// Sweeps are matched to one that is no farther away than this, m and rad.
constexpr double key_way = 1, key_turn = 20 * rad_per_deg, gate_m = 1.0;
// If no more of the returns are where they were, the surroundings are others: beside a vehicle that stands,
// people and vehicles change less.
constexpr double least_unchanged = 0.5;
constexpr std::size_t fewest_compared = 60, in_a_row = 2;

/// A sweep and what of it is not of the ground.
struct Look {
  std::vector<Surface> surfaces;
  std::vector<Surroundings> rings;
};

Look look_of(const DriveSweep& sweep, const Eigen::Matrix3d& tilt, double lowest) {
  static const DriveTrack standing({{-1e9, {}}, {1e9, {}}});
  Look look;
  std::vector<StillView> views;
  look.surfaces = surfaces_of(sweep, tilt, {}, -sweep.time, standing, &views);
  for (StillView& view : views) {
    view.beams.erase(std::remove_if(view.beams.begin(), view.beams.end(),
                                    [&](const StillBeam& beam) { return beam.height < lowest; }),
                     view.beams.end());
    look.rings.push_back({{std::move(view)}, {}, 0});
  }
  return look;
}

/// The share of returns that are where the other look has them; 1 if there are too few.
double unchanged(const Look& a, const Look& b, const PlanarPose& moved) {
  Agreement all;
  for (std::size_t ring = 0; ring < std::min(a.rings.size(), b.rings.size()); ++ring) {
    const Agreement one = agreement(a.rings[ring], b.rings[ring], moved);
    all.confirmed += one.confirmed, all.refuted += one.refuted;
  }
  return all.judged() < fewest_compared ? 1 : all.share();
}

bool is_move(const PlanarPose& pose) {
  return std::hypot(pose.x, pose.y) > least_way || std::abs(pose.yaw) > least_turn;
}

}  // namespace

std::optional<SeenMotion> find_motion(const std::vector<DriveSweep>& sweeps, const Eigen::Matrix3d& tilt,
                                      const PlanarPose& mount, double lowest) {
  if (sweeps.empty()) return std::nullopt;
  const Look first = look_of(sweeps[0], tilt, lowest);
  Look key = first;
  PlanarPose to_key, step;  // of the key, and from it
  double turned = 0, before = 0;
  SeenMotion motion;
  std::size_t begun = 0;  // the first sweep that differs; 0: none
  std::size_t moves = 0, changes = 0;
  bool is_changed = false;
  for (std::size_t i = 1; i < sweeps.size(); ++i) {
    const Look now = look_of(sweeps[i], tilt, lowest);
    const MatchedPose match =
        refine_match(key.surfaces, now.surfaces, match_surfaces(key.surfaces, now.surfaces, step, gate_m));
    const bool is_lost =
        match.pairs < fewest_matched || 2 * match.pairs < std::min(key.surfaces.size(), now.surfaces.size());
    const PlanarPose here = to_key * match.pose;
    const Eigen::Vector3d off(match.pose.x, match.pose.y, match.pose.yaw);
    const bool is_sure = !is_lost && (off.dot(match.information * off) > least_chi_square || is_move(to_key));
    const double as_before = unchanged(first, now, {});
    const bool is_moved =
        is_sure && is_move(here) && unchanged(key, now, match.pose) >= unchanged(key, now, {});
    moves = is_moved ? moves + 1 : 0;
    changes = as_before < least_unchanged ? changes + 1 : 0;
    is_changed = is_changed || changes >= in_a_row;
    motion.is_measured = motion.is_measured || moves >= in_a_row;
    if (moves + changes > 0 && begun == 0) begun = i;
    if (moves + changes == 0 && !is_changed && !motion.is_measured) begun = 0;
    if (is_lost) continue;
    turned += std::remainder(here.yaw - before, two_pi), before = here.yaw;
    step = match.pose;
    if (motion.is_measured) {
      const PlanarPose vehicle = mount * here * mount.inverse();
      motion.way = std::max(motion.way, std::hypot(vehicle.x, vehicle.y));
      motion.turn = std::max(motion.turn, std::abs(turned));
    }
    if (std::hypot(step.x, step.y) > key_way || std::abs(step.yaw) > key_turn)
      key = now, to_key = here, step = {};
  }
  if (!is_changed && !motion.is_measured) return std::nullopt;
  motion.time = sweeps[begun].time;
  return motion;
}

}  // namespace lidard
