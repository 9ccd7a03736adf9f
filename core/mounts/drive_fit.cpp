// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/drive_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.h"
#include "core/mounts/surface_match.h"

namespace lidard {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int match_rounds = 3, fit_rounds = 6;
constexpr std::size_t fewest_moves = 10, fewest_pairs = 4;
// Before the drive, a configured pose is known so well (m, rad, s), and the odometry's scales. In a direction
// that the drive does not show, this is what is known after it.
constexpr double prior_position = 0.3, prior_yaw = 10 * rad_per_deg, prior_time = 0.1, prior_scale = 0.05;
// What is known no better than this is not determined: m, m, rad, s.
constexpr std::array<double, 4> worst_known{0.02, 0.02, 0.2 * rad_per_deg, 0.002};
// No deviation is smaller.
constexpr std::array<double, 4> floor_known{0.0002, 0.0002, 0.001 * rad_per_deg, 0.00005};
// The walk of the odometry is taken for no smaller than this: m and rad after 1 m.
constexpr double least_way_noise = 0.0005, least_turn_noise = 0.01 * rad_per_deg;
constexpr double move_freedom = 8;  // of Student's distribution
// Steps for derivatives: m, rad and scales; s, so long that the noise of the odometry does not matter.
constexpr double small_step = 1e-4, time_step = 0.1;

/// The unknowns: x, y and yaw of each sensor that none other holds, a time offset of each, both scales.
struct DriveState {
  std::vector<PlanarPose> poses;
  std::vector<double> offsets;
  double scale = 1, turn_scale = 1;
};

class Unknowns {
 public:
  explicit Unknowns(const std::vector<DrivenSensor>& sensors)
      : sensors_(sensors), pose_indices_(sensors.size()) {
    for (std::size_t s = 0; s < sensors.size(); ++s) {
      if (sensors[s].held_by == s) pose_indices_[s] = count_, count_ += 3;
    }
    count_ += static_cast<Eigen::Index>(sensors.size()) + 2;
  }
  Eigen::Index size() const { return count_; }
  /// Of x; those of y and yaw follow.
  Eigen::Index pose_index(std::size_t sensor) const { return pose_indices_[sensors_[sensor].held_by]; }
  Eigen::Index offset(std::size_t sensor) const {
    return count_ - 2 - static_cast<Eigen::Index>(sensors_.size() - sensor);
  }
  Eigen::Index scale() const { return count_ - 2; }
  Eigen::Index turn_scale() const { return count_ - 1; }

  DriveState moved(const DriveState& from, const VectorXd& change) const {
    DriveState to = from;
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      const PlanarPose& holder = from.poses[sensors_[s].held_by];
      const Vector3d step = change.segment<3>(pose_index(s));
      to.poses[s] = PlanarPose{holder.x + step[0], holder.y + step[1], holder.yaw + step[2]} *
                    (holder.inverse() * from.poses[s]);
      to.offsets[s] += change[offset(s)];
    }
    to.scale += change[scale()], to.turn_scale += change[turn_scale()];
    return to;
  }
  /// What was known before the drive: weights, and how far a state is from it.
  VectorXd prior_weights() const {
    VectorXd weights = VectorXd::Constant(count_, 1 / (prior_time * prior_time));
    for (std::size_t s = 0; s < sensors_.size(); ++s)
      weights.segment<3>(pose_index(s)) =
          Vector3d(1 / (prior_position * prior_position), 1 / (prior_position * prior_position),
                   1 / (prior_yaw * prior_yaw));
    weights.tail<2>().setConstant(1 / (prior_scale * prior_scale));
    return weights;
  }
  VectorXd from_prior(const DriveState& state) const {
    VectorXd off = VectorXd::Zero(count_);
    for (std::size_t s = 0; s < sensors_.size(); ++s) {
      off[offset(s)] = state.offsets[s];
      if (sensors_[s].held_by != s) continue;
      const PlanarPose &now = state.poses[s], &before = sensors_[s].configured;
      off.segment<3>(pose_index(s)) =
          Vector3d(now.x - before.x, now.y - before.y, std::remainder(now.yaw - before.yaw, two_pi));
    }
    off[scale()] = state.scale - 1, off[turn_scale()] = state.turn_scale - 1;
    return off;
  }

 private:
  const std::vector<DrivenSensor>& sensors_;
  std::vector<Eigen::Index> pose_indices_;
  Eigen::Index count_ = 0;
};

/// How a sensor moved between two sweeps, as what it saw shows.
struct Move {
  std::size_t sensor = 0, block = 0;
  double from = 0, to = 0;  // s, by the sensor's stamps
  MatchedPose seen;         // of the second sweep in the frame of the first
};

PlanarPose motion_of(const DriveTrack& track, double from, double to) {
  return track.at(from).inverse() * track.at(to);
}

std::vector<Move> find_moves(const std::vector<DrivenSensor>& sensors, const DriveState& state,
                             const DriveTrack& track, double gate) {
  std::vector<Move> moves;
  for (std::size_t s = 0; s < sensors.size(); ++s) {
    const PlanarPose& mount = state.poses[s];
    const DriveSweep* before = nullptr;
    std::vector<Surface> old, now;
    for (const DriveSweep& sweep : sensors[s].sweeps) {
      const double time = sweep.time + state.offsets[s];
      if (!track.covers(time - 0.3) || !track.covers(time + 0.5)) continue;
      now = surfaces_of(sweep, sensors[s].tilt, mount, state.offsets[s], track);
      if (before != nullptr && sweep.time - before->time < 2 * keyframe_s) {
        const double from = before->time + state.offsets[s];
        const PlanarPose start = mount.inverse() * motion_of(track, from, time) * mount;
        Move move{s, static_cast<std::size_t>(std::max(0.0, sweep.time / keyframe_s)), before->time,
                  sweep.time, refine_match(old, now, match_surfaces(old, now, start, gate))};
        if (move.seen.pairs >= fewest_pairs) moves.push_back(move);
      }
      before = &sweep, old.swap(now);
    }
  }
  return moves;
}

/// By how much the odometry of a move must be wrong, in base_frame: m, m, rad.
Vector3d error_of(const Move& move, const DriveState& state, const DriveTrack& track) {
  const double offset = state.offsets[move.sensor];
  const PlanarPose& mount = state.poses[move.sensor];
  const PlanarPose error = motion_of(track, move.from + offset, move.to + offset).inverse() *
                           (mount * move.seen.pose * mount.inverse());
  return {error.x, error.y, error.yaw};
}

/// What the noise of the ranges adds to it.
Matrix3d match_variance(const Move& move, const PlanarPose& mount) {
  Matrix3d turn = Matrix3d::Identity();
  const PlanarPose back{0, 0, mount.yaw - move.seen.pose.yaw};
  turn.col(0).head<2>() = back.turned({1, 0}), turn.col(1).head<2>() = back.turned({0, 1});
  turn.col(2).head<2>() = Vector2d(mount.y, -mount.x);
  return turn * move.seen.information.inverse() * turn.transpose();
}

/// One step of least squares, and what is needed for the deviations.
class DriveFit {
 public:
  DriveFit(const std::vector<OdometryPose>& odometry, const std::vector<DrivenSensor>& sensors)
      : odometry_(odometry), unknowns_(sensors), prior_(unknowns_.prior_weights()) {}
  const Unknowns& unknowns() const { return unknowns_; }
  double way_noise() const { return way_noise_; }
  double turn_noise() const { return turn_noise_; }

  DriveState step(const std::vector<Move>& moves, const DriveState& state) {
    sum(moves, state);
    const VectorXd change = levers_.ldlt().solve(pulls_);
    return change.allFinite() ? unknowns_.moved(state, change) : state;
  }
  /// Moves of one time have the errors of the odometry in common, which the sums of their pulls show.
  MatrixXd covariance(const std::vector<Move>& moves, const DriveState& state) {
    sum(moves, state);
    const MatrixXd inverse = slopes_.ldlt().solve(MatrixXd::Identity(slopes_.rows(), slopes_.cols()));
    MatrixXd spread = MatrixXd::Zero(slopes_.rows(), slopes_.cols());
    double used = 0;
    for (const VectorXd& block : blocks_) spread += block * block.transpose(), used += block.isZero() ? 0 : 1;
    constexpr double unknowns_of_a_sensor = 6;
    spread *= used / std::max(1.0, used - unknowns_of_a_sensor);
    spread += prior_.asDiagonal();
    MatrixXd covariance = inverse * spread * inverse;
    // A short drive shows its own errors badly.
    const VectorXd larger =
        (inverse.diagonal().array() / covariance.diagonal().array()).max(1).sqrt().matrix();
    return larger.asDiagonal() * covariance * larger.asDiagonal();
  }

 private:
  void sum(const std::vector<Move>& moves, const DriveState& state);
  /// The states with one unknown a step less and a step more, with their tracks.
  struct Sides {
    struct Side {
      DriveState state;
      DriveTrack track;
    } low, high;
    double width;
  };
  using Slopes = Eigen::Matrix<double, 3, 6>;
  Slopes slopes_of(const Move& move, const std::vector<Sides>& sides,
                   const std::array<Eigen::Index, 6>& touched) const;
  std::vector<Sides> sides_of(const DriveState& state) const {
    std::vector<Sides> sides;
    for (Eigen::Index u = 0; u < unknowns_.size(); ++u) {
      const bool is_time = u >= unknowns_.offset(0) && u < unknowns_.scale();
      const double step = is_time ? time_step : small_step;
      const auto beside = [&](double by) {
        const DriveState moved = unknowns_.moved(state, by * VectorXd::Unit(unknowns_.size(), u));
        return Sides::Side{moved, DriveTrack(odometry_, moved.scale, moved.turn_scale)};
      };
      sides.push_back({beside(-step), beside(step), 2 * step});
    }
    return sides;
  }

  const std::vector<OdometryPose>& odometry_;
  Unknowns unknowns_;
  VectorXd prior_;
  MatrixXd levers_, slopes_;  // of a step, and by how much the pulls change
  VectorXd pulls_;
  std::vector<VectorXd> blocks_;
  double way_noise_ = 0.005, turn_noise_ = 0.2 * rad_per_deg;
};

/// How the error of a move changes with the unknowns that it depends on, as columns.
DriveFit::Slopes DriveFit::slopes_of(const Move& move, const std::vector<Sides>& sides,
                                     const std::array<Eigen::Index, 6>& touched) const {
  Slopes slopes;
  for (std::size_t i = 0; i < touched.size(); ++i) {
    const auto& [low, high, width] = sides[static_cast<std::size_t>(touched[i])];
    slopes.col(static_cast<Eigen::Index>(i)) =
        (error_of(move, high.state, high.track) - error_of(move, low.state, low.track)) / width;
  }
  return slopes;
}

void DriveFit::sum(const std::vector<Move>& moves, const DriveState& state) {
  const DriveTrack track(odometry_, state.scale, state.turn_scale);
  const std::vector<Sides> sides = sides_of(state);
  levers_ = slopes_ = prior_.asDiagonal();
  pulls_ = -prior_.cwiseProduct(unknowns_.from_prior(state));
  blocks_.clear();
  double ways = 0, way_square = 0, turn_square = 0;
  for (const Move& move : moves) {
    const Vector3d error = error_of(move, state, track);
    const Matrix3d by_match = match_variance(move, state.poses[move.sensor]);
    const double way = std::max(0.05, track.way(move.to) - track.way(move.from));
    Matrix3d variance = by_match;
    variance.diagonal() +=
        way * Vector3d(way_noise_ * way_noise_, way_noise_ * way_noise_, turn_noise_ * turn_noise_);
    const Matrix3d weight = variance.inverse();
    const double chi = error.dot(weight * error), trust = (move_freedom + 3) / (move_freedom + chi);
    // An error that grows loses trust, so that its pull grows by less.
    const double growth = 1 - 2 * chi / (3 * (move_freedom + chi));
    const Eigen::Index x = unknowns_.pose_index(move.sensor);
    const std::array<Eigen::Index, 6> touched{
        x, x + 1, x + 2, unknowns_.offset(move.sensor), unknowns_.scale(), unknowns_.turn_scale()};
    const Slopes slopes = slopes_of(move, sides, touched);
    while (blocks_.size() <= move.block) blocks_.emplace_back(VectorXd::Zero(pulls_.size()));
    const Eigen::Matrix<double, 6, 1> pull = -trust * slopes.transpose() * weight * error;
    const Eigen::Matrix<double, 6, 6> lever = trust * slopes.transpose() * weight * slopes;
    for (std::size_t i = 0; i < touched.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      pulls_[touched[i]] += pull[row], blocks_[move.block][touched[i]] += pull[row];
      for (std::size_t j = 0; j < touched.size(); ++j) {
        levers_(touched[i], touched[j]) += lever(row, static_cast<Eigen::Index>(j));
        slopes_(touched[i], touched[j]) += growth * lever(row, static_cast<Eigen::Index>(j));
      }
    }
    ways += trust * way;
    way_square += trust * (error.head<2>().squaredNorm() - by_match.diagonal().head<2>().sum()) / 2;
    turn_square += trust * (error[2] * error[2] - by_match(2, 2));
  }
  if (ways <= 0) return;
  way_noise_ = std::sqrt(std::max(least_way_noise * least_way_noise, way_square / ways));
  turn_noise_ = std::sqrt(std::max(least_turn_noise * least_turn_noise, turn_square / ways));
}

/// What is determined, and the pose with all else as configured.
DriveEstimate estimate_of(std::size_t s, const std::vector<DrivenSensor>& sensors, const DriveState& state,
                          const Unknowns& unknowns, const MatrixXd& covariance) {
  DriveEstimate estimate;
  const std::size_t holder = sensors[s].held_by;
  const PlanarPose &configured = sensors[holder].configured, &found = state.poses[holder];
  // From the unknowns to x, y, yaw of the holder and the time offset, and of this sensor.
  MatrixXd own = MatrixXd::Zero(4, unknowns.size());
  own.block<3, 3>(0, unknowns.pose_index(s)).setIdentity();
  own(3, unknowns.offset(s)) = 1;
  const auto sigmas = [&] { return (own * covariance * own.transpose()).diagonal().cwiseSqrt().eval(); };
  const Eigen::Vector4d sigma = sigmas();
  const auto is_known = [&](int i) { return sigma[i] < worst_known[static_cast<std::size_t>(i)]; };
  const bool position = is_known(0) && is_known(1);
  estimate.determined = {position, position, is_known(2), is_known(3)};
  const PlanarPose kept{position ? found.x : configured.x, position ? found.y : configured.y,
                        is_known(2) ? found.yaw : configured.yaw};
  estimate.pose = kept * (configured.inverse() * sensors[s].configured);
  estimate.time_offset = is_known(3) ? state.offsets[s] : 0;
  own(0, unknowns.pose_index(s) + 2) = kept.y - estimate.pose.y;
  own(1, unknowns.pose_index(s) + 2) = estimate.pose.x - kept.x;
  estimate.covariance = own * covariance * own.transpose();
  for (Eigen::Index i = 0; i < 4; ++i) {
    const double least = floor_known[static_cast<std::size_t>(i)];
    estimate.covariance(i, i) += least * least;
  }
  return estimate;
}

}  // namespace

std::vector<Surface> surfaces_of(const DriveSweep& sweep, const Matrix3d& tilt, const PlanarPose& mount,
                                 double offset, const DriveTrack& track, std::vector<StillView>* all) {
  const double time = sweep.time + offset;
  const PlanarPose back = (track.at(time) * mount).inverse();
  std::vector<StillView> views;
  PlanarPose moved;
  float transformed = std::numeric_limits<float>::quiet_NaN();
  for (const DriveSweep::Return& seen : sweep.returns) {
    while (views.size() <= seen.ring) {
      views.emplace_back();
      views.back().step = sweep.step, views.back().ring = views.size() - 1;
    }
    // Within half a millisecond the vehicle hardly moves.
    constexpr float tick = 0.0005F;
    if (!(std::abs(seen.later - transformed) <= tick / 2)) {
      transformed = seen.later + tick / 2;
      moved = back * track.at(time + static_cast<double>(transformed)) * mount;
    }
    const Vector3d level = tilt * seen.point.cast<double>();
    StillBeam beam;
    beam.point = moved * Vector2d(level.head<2>());
    beam.range = beam.point.norm(), beam.height = level.z();
    views[seen.ring].beams.push_back(beam);
  }
  std::vector<double> scratch;
  for (StillView& view : views) estimate_noise(view, scratch);
  std::vector<Surface> surfaces;
  if (views.size() > 1)
    surfaces = find_upright(views);
  else if (!views.empty())
    find_surfaces(views[0], surfaces);
  if (all != nullptr) *all = std::move(views);
  return surfaces;
}

DriveSolution solve_drive(const std::vector<OdometryPose>& odometry,
                          const std::vector<DrivenSensor>& sensors) {
  DriveSolution solution;
  DriveState state;
  for (const DrivenSensor& sensor : sensors) {
    solution.sensors.emplace_back();
    solution.sensors.back().pose = sensor.configured;
    state.poses.push_back(sensor.configured), state.offsets.push_back(0);
  }
  if (odometry.size() < 3) return solution;
  DriveFit fit(odometry, sensors);
  std::vector<Move> moves;
  for (int round = 0; round < match_rounds; ++round) {
    const DriveTrack track(odometry, state.scale, state.turn_scale);
    moves = find_moves(sensors, state, track, round == 0 ? 1.0 : 0.2);
    if (moves.size() < fewest_moves) return solution;
    for (int i = 0; i < fit_rounds; ++i) state = fit.step(moves, state);
  }
  const MatrixXd covariance = fit.covariance(moves, state);
  for (std::size_t s = 0; s < sensors.size(); ++s)
    solution.sensors[s] = estimate_of(s, sensors, state, fit.unknowns(), covariance);
  for (const Move& move : moves) ++solution.sensors[move.sensor].moves;
  solution.scale = state.scale, solution.turn_scale = state.turn_scale;
  const Eigen::Index scale = fit.unknowns().scale(), turn = fit.unknowns().turn_scale();
  solution.scale_sigma = std::sqrt(covariance(scale, scale));
  solution.turn_scale_sigma = std::sqrt(covariance(turn, turn));
  solution.way_noise = fit.way_noise(), solution.turn_noise = fit.turn_noise();
  return solution;
}

}  // namespace lidard
