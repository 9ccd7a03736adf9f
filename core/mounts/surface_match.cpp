// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/surface_match.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/base/angle.h"

namespace lidard {
namespace {

using Eigen::Vector2d;

constexpr double paired_gate = 0.12, paired_slope = 5 * rad_per_deg, paired_overlap = 0.3;
// m, error that the returns of a surface have in common.
constexpr double common_error = 0.002;
constexpr double match_freedom = 5;  // of Student's distribution

const Surface* partner_of(const Surface& b, const std::vector<Surface>& a, const PlanarPose& a_from_b,
                          double gate) {
  const Vector2d middle = a_from_b * b.middle, normal = a_from_b.turned(b.normal);
  const Surface* nearest = nullptr;
  double least = gate;
  for (const Surface& surface : a) {
    if (surface.ring != b.ring || surface.normal.dot(normal) < std::cos(paired_slope)) continue;
    const double off = std::abs(surface.normal.dot(middle - surface.middle)),
                 along = surface.along.dot(middle - surface.middle);
    const double overlap =
        std::min(surface.to, along + b.length() / 2) - std::max(surface.from, along - b.length() / 2);
    if (off >= least || overlap < paired_overlap * std::min(surface.length(), b.length())) continue;
    nearest = &surface, least = off;
  }
  return nearest;
}

/// Adds what a pair of surfaces says: how far, and by what angle, they are apart.
void add_pair(const Surface& a, const Surface& b, const PlanarPose& pose, Eigen::Matrix3d& levers,
              Eigen::Vector3d& pulls) {
  const Vector2d turned = pose.turned(b.middle), d = pose * b.middle - a.middle,
                 normal = pose.turned(b.normal);
  const double off = a.normal.dot(d), along = a.along.dot(d);
  const double slope =
      std::atan2(a.normal.x() * normal.y() - a.normal.y() * normal.x(), a.normal.dot(normal));
  const double length = std::min(a.length(), b.length()), bias = common_error * common_error;
  const double var_off = a.var_offset + b.var_offset + along * along * a.var_slope + bias,
               var_slope = a.var_slope + b.var_slope + 12 * bias / (length * length);
  const double chi = off * off / var_off + slope * slope / var_slope;
  const double trust = (match_freedom + 2) / (match_freedom + chi);
  const Eigen::Vector3d lever(a.normal.x(), a.normal.y(),
                              a.normal.y() * turned.x() - a.normal.x() * turned.y());
  levers += trust / var_off * lever * lever.transpose();
  levers(2, 2) += trust / var_slope;
  pulls -= trust / var_off * off * lever;
  pulls[2] -= trust / var_slope * slope;
}

}  // namespace

MatchedPose refine_match(const std::vector<Surface>& a, const std::vector<Surface>& b, PlanarPose pose,
                         double gate) {
  MatchedPose match;
  constexpr int rounds = 6;
  for (int round = 0; round < rounds; ++round, gate /= 2) {
    Eigen::Matrix3d levers = Eigen::Matrix3d::Identity();
    Eigen::Vector3d pulls = Eigen::Vector3d::Zero();
    match.pairs = 0;
    for (const Surface& surface : b) {
      const Surface* const partner = partner_of(surface, a, pose, std::max(paired_gate, gate));
      if (partner == nullptr) continue;
      ++match.pairs;
      add_pair(*partner, surface, pose, levers, pulls);
    }
    const Eigen::Vector3d change = levers.ldlt().solve(pulls);
    pose = {pose.x + change[0], pose.y + change[1], std::remainder(pose.yaw + change[2], two_pi)};
    match.information = levers;
  }
  match.pose = pose;
  return match;
}

}  // namespace lidard
