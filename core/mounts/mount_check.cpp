// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/mount_check.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/angle.h"

namespace lidard {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr Span period = std::chrono::milliseconds(200), confirmed_after = std::chrono::seconds(5);
constexpr double memory_s = 5;
constexpr double same_surface_m = 0.4;
constexpr std::size_t fewest_surfaces = 2;
// Larger differences count, m and rad, if they exceed so many standard deviations.
constexpr double tolerance_m = 0.015, tolerance_rad = 0.25 * rad_per_deg, significant = 2;
// So many comparisons in a row that differ from the ones before are a mount that has moved.
constexpr std::size_t comparisons_of_change = 6;
// A pose far from the configured one must explain so much more of the returns that both should see. Farther
// off, another wall of a room that looks alike from both ends would do.
constexpr double better_share = 0.1, largest_shift_m = 1.5;
// Two surfaces fit at more than one pose, unless it explains so many of the returns.
constexpr double certain_share = 0.9;
// If less than this share of them is where both look, none sees what the other sees: scanners of different
// heights agree on more. So many must be judged.
constexpr double astray_share = 0.4;
constexpr std::size_t fewest_judged = 50;
// If the surroundings move by less between two comparisons, the vehicle counts as standing: two sweeps are
// much closer in time. A turn counts by the way of what is 5 m away.
constexpr double standing_m = 0.03, turning_arm_m = 5;
// Share of the evidence that is required for a direction.
constexpr double determined_share = 0.02;

/// A correction along the directions that the surfaces determine, 0 along the others.
struct Solution {
  Vector3d value{0, 0, 0};
  Matrix3d covariance = Matrix3d::Zero();
  std::array<bool, 3> determined{true, true, true};
};

/// Least squares, with yaw as a length, so that the three can be compared.
Solution solve(const Matrix3d& levers, const Vector3d& pulls) {
  Solution solution;
  const double evidence = levers(0, 0) + levers(1, 1);
  const Vector3d scale(1, 1, std::sqrt(evidence / std::max(levers(2, 2), 1e-6 * evidence)));
  const Eigen::SelfAdjointEigenSolver<Matrix3d> parts(
      Matrix3d(scale.asDiagonal() * levers * scale.asDiagonal()));
  for (int i = 0; i < 3; ++i) {
    const Vector3d direction = parts.eigenvectors().col(i);
    if (parts.eigenvalues()[i] > determined_share * evidence) {
      const Vector3d moved = scale.cwiseProduct(direction);
      solution.covariance += moved * moved.transpose() / parts.eigenvalues()[i];
      continue;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      if (std::abs(direction[static_cast<int>(c)]) > 0.3) solution.determined[c] = false;
    }
  }
  solution.value = solution.covariance * pulls;
  return solution;
}

/// True if a difference exceeds what is tolerated and what chance may make of it.
bool is_large(const Vector3d& off, const Vector3d& sigma) {
  return off.head<2>().norm() > tolerance_m + significant * sigma.head<2>().maxCoeff() ||
         std::abs(off[2]) > tolerance_rad + significant * sigma[2];
}

}  // namespace

MountCheck::MountCheck(std::size_t sources) : sources_(sources) {
  for (std::size_t a = 0; a < sources; ++a) {
    for (std::size_t b = a + 1; b < sources; ++b) pairs_.push_back({a, b});
  }
  reset();
}

void MountCheck::reset() {
  updated_.reset();
  for (Source& source : sources_) source.surfaces.clear();
  memories_.assign(pairs_.size(), {}), changed_ = memories_;
  far_.assign(pairs_.size(), {});
  for (MountDifference& pair : pairs_) pair = {pair.first, pair.second};
}

bool MountCheck::is_due(Stamp stamp) const {
  return !updated_ || stamp - *updated_ >= period || *updated_ - stamp > restart_limit;
}

void MountCheck::Memory::add(const MatchedPose& look, const Vector3d& off, Stamp stamp, double kept) {
  if (comparisons++ == 0) begin = stamp;
  weight = weight * kept + 1, square = square * kept + off.dot(look.information * off);
  levers = levers * kept + look.information, pulls = pulls * kept + look.information * off;
}

/// True if the surroundings are where they were in the comparison before.
bool MountCheck::Source::stands() const {
  const MatchedPose moved = refine_match(before, surfaces, {}, same_surface_m);
  return moved.pairs >= fewest_surfaces && 2 * moved.pairs >= surfaces.size() &&
         std::hypot(moved.pose.x, moved.pose.y) + turning_arm_m * std::abs(moved.pose.yaw) < standing_m;
}

void MountCheck::find_source(const PlacedScan& sweep, const Vector2d& viewpoint, Source& source) {
  StillView& view = source.views[0];
  view.beams.resize(sweep.kind.size());
  view.step = 0;
  for (std::size_t i = 0; i < sweep.kind.size(); ++i) {
    StillBeam& beam = view.beams[i];
    beam.point = Vector2d(static_cast<double>(sweep.x[i]), static_cast<double>(sweep.y[i])) - viewpoint;
    beam.range =
        sweep.kind[i] == Return::surface ? beam.point.norm() : std::numeric_limits<double>::quiet_NaN();
    if (view.step > 0 || i == 0 || !beam.is_hit() || !view.beams[i - 1].is_hit()) continue;
    view.step = std::acos(
        std::min(1.0, beam.point.dot(view.beams[i - 1].point) / (beam.range * view.beams[i - 1].range)));
  }
  estimate_noise(view, scratch_);
  find_surfaces(view, source.surfaces);
}

/// The pose near the configured one that fits the surfaces. Where few fit, a pose far off, as of a mount that
/// is wrong by many degrees, if it explains more of the returns.
MatchedPose MountCheck::match(std::size_t index, const PlanarPose& configured, Stamp stamp) {
  MountDifference& pair = pairs_[index];
  const Source &first = sources_[pair.first], &second = sources_[pair.second];
  MatchedPose near = refine_match(first.surfaces, second.surfaces, configured, same_surface_m);
  auto& [far, next_search] = far_[index];
  const bool fits = near.pairs > fewest_surfaces;
  if (fits) far.reset(), pair.astray_since.reset(), pair.is_astray = false;
  if (fits || (!far && stamp < next_search)) return near;
  next_search = stamp + std::chrono::seconds(1);
  const Agreement now = agreement(first, second, configured);
  MatchedPose other = refine_match(first.surfaces, second.surfaces,
                                   far ? *far : match_surfaces(first.surfaces, second.surfaces, configured));
  const double moved = other.pose.distance_to(configured);
  const double share = agreement(first, second, other.pose).share();
  const bool is_unique =
      other.pairs > fewest_surfaces || (other.pairs == fewest_surfaces && share >= certain_share);
  const bool is_better = moved < largest_shift_m && now.judged() >= fewest_judged &&
                         other.pairs > near.pairs && is_unique && share >= now.share() + better_share;
  far = is_better ? std::optional<PlanarPose>(other.pose) : std::nullopt;
  const bool is_astray = !is_better && near.pairs < fewest_surfaces && now.judged() >= fewest_judged &&
                         now.share() < astray_share;
  if (!is_astray)
    pair.astray_since.reset();
  else if (!pair.astray_since)
    pair.astray_since = stamp;
  pair.is_astray = is_astray && stamp - *pair.astray_since >= confirmed_after;
  return is_better ? other : near;
}

void MountCheck::assess(const Memory& memory, MountDifference& pair) {
  const Solution solution = solve(memory.levers, memory.pulls);
  pair.correction = solution.value, pair.determined = solution.determined;
  const double chi_square =
      (memory.square - solution.value.dot(memory.levers * solution.value)) / (3 * memory.weight);
  pair.sigma =
      (std::max(1.0, chi_square) * memory.weight * solution.covariance.diagonal()).cwiseMax(0).cwiseSqrt();
}

void MountCheck::compare(std::size_t index, const Vector2d& offset, Stamp stamp, double kept) {
  MountDifference& pair = pairs_[index];
  Memory &memory = memories_[index], &changed = changed_[index];
  const MatchedPose look = match(index, {offset.x(), offset.y(), 0}, stamp);
  pair.surfaces = look.pairs >= fewest_surfaces ? look.pairs : 0;
  if (pair.surfaces == 0) return;
  const Vector3d off(look.pose.x - offset.x(), look.pose.y - offset.y(), look.pose.yaw);
  const Solution alone = solve(look.information, look.information * (off - pair.correction));
  const bool differs = memory.comparisons > 0 && is_large(alone.value, pair.sigma);
  (differs ? changed : memory).add(look, off, stamp, kept);
  if (!differs) changed = {};
  if (changed.comparisons >= comparisons_of_change) memory = std::exchange(changed, {});
  assess(memory, pair);
  if (!is_large(pair.correction, pair.sigma))
    pair.since.reset();
  else if (!pair.since)  // a mount that has just moved differs since the first comparison after that
    pair.since = memory.comparisons < 2 * comparisons_of_change ? memory.begin : stamp;
  pair.is_wrong = pair.since && stamp - *pair.since >= confirmed_after;
}

void MountCheck::update(Stamp stamp, const std::vector<const PlacedScan*>& sweeps,
                        const std::vector<Vector2d>& viewpoints, bool deskewed) {
  if (updated_ && *updated_ - stamp > restart_limit) reset();
  const double passed = updated_ ? std::max(0.0, seconds(stamp - *updated_)) : 0;
  updated_ = stamp;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    sources_[s].before.swap(sources_[s].surfaces);
    sources_[s].surfaces.clear();
    if (sweeps[s] != nullptr) find_source(*sweeps[s], viewpoints[s], sources_[s]);
  }
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    const std::size_t first = pairs_[i].first, second = pairs_[i].second;
    if (sweeps[first] == nullptr || sweeps[second] == nullptr) continue;
    if (deskewed || (sources_[first].stands() && sources_[second].stands()))
      compare(i, viewpoints[second] - viewpoints[first], stamp, std::exp(-passed / memory_s));
  }
}

std::optional<std::size_t> MountCheck::wrong_source() const {
  std::optional<std::size_t> wrong;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    std::size_t with = 0, agreeing = 0, others = 0;
    for (const MountDifference& pair : pairs_) {
      const bool is_own = pair.first == s || pair.second == s;
      if (pair.is_wrong || pair.is_astray)
        ++(is_own ? with : others);
      else if (pair.surfaces > 0 && is_own)
        ++agreeing;
    }
    if (with == 0 || others > 0 || agreeing > 0) continue;
    if (wrong) return std::nullopt;
    wrong = s;
  }
  return wrong;
}

}  // namespace lidard
