// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/drive_fit.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/angle.h"

namespace lidard {
namespace {

using Eigen::Vector2d;

constexpr double keyframe_s = 0.4, later_s[] = {0.4, 0.8, 1.6};
constexpr double gates[] = {0.35, 0.25, 0.15, 0.10, 0.06, 0.06, 0.06};
constexpr double same_normal = 0.94;  // cosine of 20 degrees
constexpr std::size_t every_return = 4;
// Pairs of sweeps that follow each other share the walk of the odometry: deviations come from the pulls of
// blocks of the drive, and are still this much too small.
constexpr double block_s = 4, blocks_share = 1.65;
// A direction is determined where independent residuals know it this much better than needed.
constexpr double walk = 7;
// A drive shows all unknowns if it turns both ways: rad/s about the mean, rad each way, m.
constexpr double least_turning = 0.2, least_turn = 90 * rad_per_deg, least_way = 10;
// What is known no better than this is not determined: m, m, rad, s.
constexpr double worst[] = {0.02, 0.02, 0.2 * rad_per_deg, 0.002};
constexpr double time_floor = 0.00005;

/// The odometry with its distances and angles scaled.
class Track {
 public:
  Track(const std::vector<OdometryPose>& odometry, double scale, double turn_scale) : poses_(odometry) {
    for (std::size_t i = 1; i < poses_.size(); ++i) {
      PlanarPose step = odometry[i - 1].pose.inverse() * odometry[i].pose;
      step = {scale * step.x, scale * step.y, turn_scale * step.yaw};
      poses_[i].pose = poses_[i - 1].pose * step;
    }
  }
  bool covers(double time) const {
    return !poses_.empty() && time >= poses_.front().time && time <= poses_.back().time;
  }
  PlanarPose at(double time) const {
    auto next = std::lower_bound(poses_.begin(), poses_.end(), time,
                                 [](const OdometryPose& pose, double wanted) { return pose.time < wanted; });
    next = std::clamp(next, poses_.begin() + 1, poses_.end() - 1);
    const OdometryPose &a = *(next - 1), &b = *next;
    const double share = (time - a.time) / std::max(1e-9, b.time - a.time);
    const double turn = std::remainder(b.pose.yaw - a.pose.yaw, two_pi);
    return {a.pose.x + share * (b.pose.x - a.pose.x), a.pose.y + share * (b.pose.y - a.pose.y),
            a.pose.yaw + share * turn};
  }

 private:
  std::vector<OdometryPose> poses_;
};

/// The unknowns: x, y, yaw and time offset of each sensor, then both scales.
struct State {
  std::vector<PlanarPose> poses;
  std::vector<double> offsets;
  double scale = 1, turn_scale = 1;

  std::size_t size() const { return 4 * poses.size() + 2; }
  void add(std::size_t unknown, double value) {
    const std::size_t s = unknown / 4;
    if (s == poses.size()) {
      (unknown % 4 == 0 ? scale : turn_scale) += value;
      return;
    }
    PlanarPose& pose = poses[s];
    switch (unknown % 4) {
      case 0:
        pose.x += value;
        break;
      case 1:
        pose.y += value;
        break;
      case 2:
        pose.yaw += value;
        break;
      default:
        offsets[s] += value;
    }
  }
};

/// A sweep as a view of one moment.
struct Still {
  std::size_t sensor = 0;
  double time = 0;
  std::vector<Surface> surfaces;
  std::vector<Vector2d> points, normals;
};

Still still_of(const DriveSweep& sweep, const State& state, const Track& track) {
  const PlanarPose& mount = state.poses[sweep.sensor];
  const double time = sweep.time + state.offsets[sweep.sensor];
  const PlanarPose middle = (track.at(time) * mount).inverse();
  StillView view;
  view.step = 0.5 * rad_per_deg;
  double last = 0;
  for (const DriveSweep::Return& seen : sweep.returns) {
    StillBeam beam;
    beam.point = (middle * track.at(time + seen.later) * mount) * seen.point;
    beam.range = beam.point.norm(), beam.sigma = 0.01;
    const double azimuth = std::atan2(beam.point.y(), beam.point.x());
    if (!view.beams.empty()) view.step = std::max(1e-4, std::abs(std::remainder(azimuth - last, two_pi)));
    last = azimuth;
    view.beams.push_back(beam);
  }
  Still still{sweep.sensor, sweep.time, find_surfaces(view), {}, {}};
  for (const Surface& surface : still.surfaces) {
    for (std::size_t i = surface.first_beam; i <= surface.last_beam; i += every_return)
      still.points.push_back(view.beams[i].point), still.normals.push_back(surface.normal);
  }
  return still;
}

/// Takes points of sweep `b` to sweep `a`.
PlanarPose between(const Still& a, const Still& b, const State& state, const Track& track) {
  const PlanarPose first = track.at(a.time + state.offsets[a.sensor]) * state.poses[a.sensor];
  return first.inverse() * (track.at(b.time + state.offsets[b.sensor]) * state.poses[b.sensor]);
}

const Surface* surface_at(const Still& a, const Vector2d& point, const Vector2d& normal, double gate) {
  const Surface* best = nullptr;
  double least = gate;
  for (const Surface& surface : a.surfaces) {
    const Vector2d d = point - surface.middle;
    const double off = std::abs(surface.normal.dot(d)), s = surface.along.dot(d);
    if (off >= least || s < surface.from || s > surface.to || surface.normal.dot(normal) < same_normal)
      continue;
    least = off, best = &surface;
  }
  return best;
}

/// One round of least squares.
class Round {
 public:
  Round(const std::vector<OdometryPose>& odometry, const State& state)
      : state_(state), track_(odometry, state.scale, state.turn_scale) {
    // Steps for the derivatives: m, rad and s that move what is seen by about as much.
    for (std::size_t u = 0; u < state.size(); ++u) {
      State moved = state;
      moved.add(u, step);
      moved_.push_back(moved);
    }
    const std::size_t scales = 4 * state.poses.size();
    scaled_ = {Track(odometry, moved_[scales].scale, moved_[scales].turn_scale),
               Track(odometry, moved_[scales + 1].scale, moved_[scales + 1].turn_scale)};
    levers = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(state.size()),
                                   static_cast<Eigen::Index>(state.size()));
    pulls = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(state.size()));
  }
  const Track& track() const { return track_; }

  void add(const Still& a, const Still& b, double gate) {
    const auto block = static_cast<std::size_t>(std::max(0.0, a.time) / block_s);
    while (blocks.size() <= block) blocks.emplace_back(Eigen::VectorXd::Zero(pulls.size()));
    const std::size_t scales = 4 * state_.poses.size();
    std::vector<std::size_t> unknowns;
    for (std::size_t i = 0; i < 4; ++i) unknowns.push_back(4 * a.sensor + i);
    for (std::size_t i = 0; i < 4 && b.sensor != a.sensor; ++i) unknowns.push_back(4 * b.sensor + i);
    unknowns.push_back(scales), unknowns.push_back(scales + 1);
    const PlanarPose now = between(a, b, state_, track_);
    std::vector<PlanarPose> moved;
    for (const std::size_t u : unknowns)
      moved.push_back(between(a, b, moved_[u], u < scales ? track_ : scaled_[u - scales]));
    Eigen::VectorXd row(static_cast<Eigen::Index>(unknowns.size()));
    for (std::size_t i = 0; i < b.points.size(); ++i) {
      const Vector2d q = now * b.points[i];
      const Surface* const surface = surface_at(a, q, now.turned(b.normals[i]), gate);
      if (surface == nullptr) continue;
      const double off = surface->normal.dot(q - surface->middle);
      for (std::size_t k = 0; k < unknowns.size(); ++k)
        row[static_cast<Eigen::Index>(k)] = surface->normal.dot(moved[k] * b.points[i] - q) / step;
      const double weight = 1 / std::pow(1 + off * off / (0.25 * gate * gate), 2);
      for (std::size_t k = 0; k < unknowns.size(); ++k) {
        const auto at = static_cast<Eigen::Index>(unknowns[k]);
        const double pull = -weight * off * row[static_cast<Eigen::Index>(k)];
        pulls[at] += pull, blocks[block][at] += pull;
        for (std::size_t m = 0; m < unknowns.size(); ++m)
          levers(at, static_cast<Eigen::Index>(unknowns[m])) +=
              weight * row[static_cast<Eigen::Index>(k)] * row[static_cast<Eigen::Index>(m)];
      }
      square += weight * off * off, weights += weight, ++count;
    }
  }

  Eigen::MatrixXd levers;
  Eigen::VectorXd pulls;
  std::vector<Eigen::VectorXd> blocks;  // pulls of stretches of the drive
  double square = 0, weights = 0;
  std::size_t count = 0;

 private:
  static constexpr double step = 1e-5;
  const State& state_;
  Track track_;
  std::vector<State> moved_;
  std::vector<Track> scaled_;
};

/// Directions of the unknowns of which the drive says too little, as columns; the others with their
/// eigenvalues.
struct Parts {
  Eigen::MatrixXd known;
  Eigen::VectorXd values;
  Eigen::MatrixXd unknown;
};

Parts parts_of(const Eigen::MatrixXd& levers, double variance) {
  // As lengths: yaw and scales at 5 m, time at 1 m/s.
  Eigen::VectorXd unit = Eigen::VectorXd::Ones(levers.rows());
  for (Eigen::Index i = 0; i + 2 < levers.rows(); ++i) unit[i] = i % 4 == 2 ? 1 / 5.0 : 1;
  const Eigen::MatrixXd scaled = unit.asDiagonal() * levers * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scaled);
  Parts parts;
  Eigen::Index first = 0;
  while (first < levers.rows() &&
         walk * std::sqrt(variance / std::max(1e-30, solver.eigenvalues()[first])) > worst[0] / 2)
    ++first;
  const Eigen::Index rest = levers.rows() - first;
  parts.known = unit.asDiagonal() * solver.eigenvectors().rightCols(rest);
  parts.values = solver.eigenvalues().tail(rest);
  parts.unknown = solver.eigenvectors().leftCols(first);
  return parts;
}

/// Which of x, y, yaw and time offset a drive can show at all. At constant speed and turn rate a time offset
/// is as good as another mount.
std::array<bool, 4> shown_by(const std::vector<OdometryPose>& odometry) {
  double way = 0, left = 0, right = 0, square = 0;
  const double length = odometry.back().time - odometry.front().time;
  for (std::size_t i = 1; i < odometry.size(); ++i) {
    const PlanarPose step = odometry[i - 1].pose.inverse() * odometry[i].pose;
    way += std::hypot(step.x, step.y);
    (step.yaw > 0 ? left : right) += std::abs(step.yaw);
  }
  // Turn rates over half a second, so that the odometry's noise does not count.
  const Track track(odometry, 1, 1);
  const double mean = (left - right) / length;
  double count = 0;
  for (double t = odometry.front().time; t + 0.5 < odometry.back().time; t += 0.5, ++count) {
    const double rate = std::remainder(track.at(t + 0.5).yaw - track.at(t).yaw, two_pi) / 0.5;
    square += (rate - mean) * (rate - mean);
  }
  const bool turns =
      std::sqrt(square / std::max(1.0, count)) >= least_turning && std::min(left, right) >= least_turn;
  const bool straight = std::sqrt(square / std::max(1.0, count)) < 0.02 && std::abs(mean) < 0.02;
  const bool far = way >= least_way;
  return {far && turns, far && turns, far && (turns || straight), far && turns};
}

}  // namespace

DriveSolution solve_drive(const std::vector<OdometryPose>& odometry, const std::vector<DriveSweep>& sweeps,
                          const std::vector<PlanarPose>& configured) {
  DriveSolution solution;
  solution.sensors.resize(configured.size());
  State state{configured, std::vector<double>(configured.size(), 0), 1, 1};
  for (std::size_t i = 0; i < configured.size(); ++i) solution.sensors[i].pose = configured[i];
  if (odometry.size() < 3) return solution;
  // One sweep per keyframe and sensor.
  std::vector<DriveSweep> kept;
  std::vector<double> newest(configured.size(), -1e9);
  for (const DriveSweep& sweep : sweeps) {
    if (sweep.time < newest[sweep.sensor] + keyframe_s || sweep.time < odometry.front().time + 0.2 ||
        sweep.time > odometry.back().time - 0.2)
      continue;
    newest[sweep.sensor] = sweep.time;
    kept.push_back(sweep);
  }
  const std::array<bool, 4> shows = shown_by(odometry);
  for (const double gate : gates) {
    Round round(odometry, state);
    std::vector<Still> stills;
    for (const DriveSweep& sweep : kept) stills.push_back(still_of(sweep, state, round.track()));
    for (const Still& a : stills) {
      for (const Still& b : stills) {
        const bool paired = std::any_of(std::begin(later_s), std::end(later_s), [&](double later) {
          return std::abs(b.time - a.time - later) < keyframe_s / 2;
        });
        if (paired) round.add(a, b, gate);
      }
    }
    if (round.count < 100) return solution;
    const double variance = round.square / round.weights;
    const Parts parts = parts_of(round.levers, variance);
    const Eigen::VectorXd change =
        parts.known * (parts.values.cwiseInverse().asDiagonal() * (parts.known.transpose() * round.pulls));
    for (std::size_t u = 0; u < state.size(); ++u) {
      const double limit = u % 4 == 3 && u < 4 * configured.size() ? 0.05 : 0.2;
      state.add(u, std::clamp(change[static_cast<Eigen::Index>(u)], -limit, limit));
    }
    solution.residuals = round.count, solution.rms = std::sqrt(round.square / round.weights);
    const Eigen::MatrixXd inverse =
        parts.known * parts.values.cwiseInverse().asDiagonal() * parts.known.transpose();
    Eigen::MatrixXd spread = variance * round.levers;
    for (const Eigen::VectorXd& block : round.blocks) spread += block * block.transpose();
    const Eigen::MatrixXd covariance = blocks_share * blocks_share * inverse * spread * inverse;
    for (std::size_t s = 0; s < configured.size(); ++s) {
      DriveEstimate& estimate = solution.sensors[s];
      const auto at = static_cast<Eigen::Index>(4 * s);
      estimate.pose = state.poses[s], estimate.time_offset = state.offsets[s];
      estimate.covariance = covariance.block<4, 4>(at, at);
      estimate.covariance(3, 3) += time_floor * time_floor;
      for (Eigen::Index i = 0; i < 4; ++i) {
        const bool free = parts.unknown.cols() > 0 && parts.unknown.row(at + i).norm() > 0.3;
        estimate.determined[static_cast<std::size_t>(i)] =
            shows[static_cast<std::size_t>(i)] && !free && std::sqrt(estimate.covariance(i, i)) < worst[i];
      }
    }
  }
  solution.scale = state.scale, solution.turn_scale = state.turn_scale;
  return solution;
}

}  // namespace lidard
