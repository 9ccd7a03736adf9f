// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/pose_track.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

// Over a shorter time the noise of two poses is more than the motion between them.
constexpr Span shortest_twist = std::chrono::milliseconds(10);

Pose pose_of(const Eigen::Vector3d& position, const Eigen::Quaterniond& turn) {
  Pose pose = Pose::Identity();
  pose.linear() = turn.toRotationMatrix();
  pose.translation() = position;
  return pose;
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Displacement of a body that turns by `turn` (rad, as a vector) per m of its path: the left Jacobian of the
/// rotation group.
Eigen::Matrix3d arc_matrix(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  const Eigen::Matrix3d w = cross_matrix(turn);
  if (angle < 1e-6) return Eigen::Matrix3d::Identity() + w / 2;
  return Eigen::Matrix3d::Identity() + (1 - std::cos(angle)) / (angle * angle) * w +
         (angle - std::sin(angle)) / (angle * angle * angle) * w * w;
}

Eigen::Vector3d turn_vector(Eigen::Quaterniond q) {
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const double sine = q.vec().norm();
  if (sine < 1e-12) return 2 * q.vec();
  return 2 * std::atan2(sine, q.w()) / sine * q.vec();
}

Eigen::Quaterniond turned_by(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (angle < 1e-12) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle));
}

}  // namespace

PoseTrack::PoseTrack(const PoseTrackSettings& settings)
    : settings_(settings), ring_(std::max<std::size_t>(settings.knots, 2)) {}

bool PoseTrack::add(Stamp stamp, const Pose& odom_from_base) {
  if (!is_rigid(odom_from_base)) {
    ++not_rigid_;
    return false;
  }
  if (!empty() && stamp + restart_limit < newest()) {
    clear();
    ++restarts_;
  }
  if (!empty() && stamp <= newest()) {
    ++out_of_order_;
    return false;
  }
  if (count_ == ring_.size())
    first_ = (first_ + 1) % ring_.size();
  else
    ++count_;
  ring_[(first_ + count_ - 1) % ring_.size()] = {stamp, odom_from_base.translation(),
                                                 Eigen::Quaterniond(odom_from_base.linear()).normalized()};
  return true;
}

std::size_t PoseTrack::knots_until(Stamp stamp) const {
  std::size_t low = 0;
  std::size_t high = count_;
  while (low < high) {
    const std::size_t middle = (low + high) / 2;
    if (knot(middle).stamp <= stamp)
      low = middle + 1;
    else
      high = middle;
  }
  return low;
}

/// A vehicle that stands must stay where it is to the last bit.
bool PoseTrack::same_pose(const Knot& a, const Knot& b) {
  return a.position == b.position && a.turn.coeffs() == b.turn.coeffs();
}

PoseOrigin PoseTrack::at(Stamp stamp, Pose& pose) const {
  const std::size_t next = knots_until(stamp);
  if (next == 0) return PoseOrigin::missing;
  const Knot& a = knot(next - 1);
  if (a.stamp == stamp) {
    pose = pose_of(a.position, a.turn);
    return PoseOrigin::known;
  }
  if (next == count_) return beyond(stamp, pose);
  const Knot& b = knot(next);
  if (b.stamp - a.stamp > settings_.max_pose_gap) return PoseOrigin::missing;
  if (same_pose(a, b)) {
    pose = pose_of(a.position, a.turn);
    return PoseOrigin::known;
  }
  const double share = seconds(stamp - a.stamp) / seconds(b.stamp - a.stamp);
  pose = pose_of(a.position + share * (b.position - a.position), a.turn.slerp(share, b.turn));
  return PoseOrigin::known;
}

std::size_t PoseTrack::twist_begin(std::size_t end) const {
  std::size_t begin = end;
  while (begin > 0 && knot(end).stamp - knot(begin).stamp < shortest_twist) --begin;
  return begin;
}

PoseTrack::Twist PoseTrack::twist(const Knot& from, const Knot& to) {
  if (same_pose(from, to)) return {};
  const double time = seconds(to.stamp - from.stamp);
  const Eigen::Quaterniond back = from.turn.conjugate();
  const Eigen::Vector3d turn = turn_vector(back * to.turn);
  const Eigen::Vector3d way = arc_matrix(turn).inverse() * (back * (to.position - from.position));
  return {turn / time, way / time};
}

PoseOrigin PoseTrack::beyond(Stamp stamp, Pose& pose) const {
  const Knot& last = knot(count_ - 1);
  if (stamp - last.stamp > settings_.max_extrapolation) return PoseOrigin::missing;
  const std::size_t begin = twist_begin(count_ - 1);
  const Knot& first = knot(begin);
  if (first.stamp == last.stamp || last.stamp - first.stamp > settings_.max_pose_gap)
    return PoseOrigin::missing;
  const double time = seconds(stamp - last.stamp);
  Twist now = twist(first, last);
  // The twist goes on changing as it did between the last two stretches of about equal length: at 50 Hz and
  // 2 rad/s2 a steady twist would be 4 mm off at 10 m when the next pose is due.
  const Knot& before = knot(twist_begin(begin));
  const double stretch = seconds(last.stamp - first.stamp);
  const double stretch_before = seconds(first.stamp - before.stamp);
  if (stretch_before > 0 && stretch_before < 2 * stretch && stretch < 2 * stretch_before) {
    const Twist then = twist(before, first);
    const double share = (stretch + time) / (stretch + stretch_before);
    now.turn += share * (now.turn - then.turn);
    now.way += share * (now.way - then.way);
  }
  const Eigen::Vector3d turned = time * now.turn;
  pose = pose_of(last.position + last.turn * (arc_matrix(turned) * (time * now.way)),
                 (last.turn * turned_by(turned)).normalized());
  return PoseOrigin::extrapolated;
}

bool PoseTrack::covers(Stamp first, Stamp last) const {
  Pose ignored;
  if (at(first, ignored) == PoseOrigin::missing || at(last, ignored) == PoseOrigin::missing) return false;
  const std::size_t end = knots_until(last);
  for (std::size_t i = knots_until(first); i < end; ++i) {
    if (i > 0 && knot(i).stamp - knot(i - 1).stamp > settings_.max_pose_gap) return false;
  }
  return true;
}

namespace {

constexpr Span longest_step = std::chrono::seconds(1);

}  // namespace

void DeadReckoning::speed(double meters_per_s) {
  if (std::isfinite(meters_per_s))
    speed_ = meters_per_s;
  else
    ++refused_;
}

void DeadReckoning::turn(Stamp stamp, const Eigen::Vector3d& rates, PoseTrack& track) {
  if (!rates.allFinite()) {
    ++refused_;
    return;
  }
  const bool anew = !last_ || stamp - *last_ > longest_step || *last_ - stamp > longest_step;
  if (!anew && stamp <= *last_) {
    ++refused_;
    return;
  }
  if (!anew) {
    const double dt = seconds(stamp - *last_);
    const Eigen::Vector3d turned = (rates + last_rates_) / 2 * dt;
    const double angle = turned.norm();
    const Eigen::AngleAxisd half(angle / 2,
                                 angle > 0 ? Eigen::Vector3d(turned / angle) : Eigen::Vector3d::UnitZ());
    // On a circle the chord has the heading of its middle.
    pose_ = pose_ * half * Eigen::Translation3d(speed_ * dt, 0, 0) * half;
    pose_.linear() = Eigen::Quaterniond(pose_.linear()).normalized().toRotationMatrix();
  }
  last_ = stamp;
  last_rates_ = rates;
  track.add(stamp, pose_);
}

}  // namespace lidard
