// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/world/motion.h"

#include <algorithm>
#include <cmath>

namespace lidard::sim {

Pose to_pose(const Pose2& place) { return make_pose({place.x, place.y, 0}, {0, 0, place.yaw}); }

Pose2 drive(const Pose2& from, const Twist& twist, double time) {
  Pose2 to = from;
  const double way = twist.speed * time;
  const double turn = twist.yaw_rate * time;
  to.yaw = from.yaw + turn;
  // The chord of an arc lies at half the turn; its length tends to the way as the turn tends to 0.
  const double half = turn / 2;
  const double chord = std::abs(half) < 1e-9 ? way : way * std::sin(half) / half;
  to.x = from.x + chord * std::cos(from.yaw + half);
  to.y = from.y + chord * std::sin(from.yaw + half);
  return to;
}

Trajectory::Trajectory(const Pose2& start, const std::vector<Twist>& twists) : start_(start) {
  double begin = 0;
  Pose2 place = start;
  for (const Twist& twist : twists) {
    legs_.push_back({begin, place, twist});
    place = drive(place, twist, twist.duration);
    begin += twist.duration;
  }
}

const Trajectory::Leg* Trajectory::leg_at(double time) const {
  if (legs_.empty() || time < 0) return nullptr;
  const auto next = std::upper_bound(legs_.begin(), legs_.end(), time,
                                     [](double t, const Leg& leg) { return t < leg.begin; });
  return &*(next - 1);
}

Pose2 Trajectory::at(double time) const {
  const Leg* leg = leg_at(time);
  if (leg == nullptr) return start_;
  return drive(leg->from, leg->twist, std::min(time - leg->begin, leg->twist.duration));
}

double Trajectory::speed(double time) const {
  const Leg* leg = leg_at(time);
  return leg == nullptr || time - leg->begin >= leg->twist.duration ? 0 : leg->twist.speed;
}

Waypoint interpolate(const std::vector<Waypoint>& waypoints, double time) {
  const auto next = std::upper_bound(waypoints.begin(), waypoints.end(), time,
                                     [](double t, const Waypoint& point) { return t < point.time; });
  if (next == waypoints.begin()) return waypoints.front();
  if (next == waypoints.end()) return waypoints.back();
  const Waypoint& a = *(next - 1);
  const Waypoint& b = *next;
  const double share = (time - a.time) / (b.time - a.time);
  return {time, a.position + share * (b.position - a.position), a.yaw + share * (b.yaw - a.yaw)};
}

}  // namespace lidard::sim
