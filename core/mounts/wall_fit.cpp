// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/wall_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "core/base/angle.h"

namespace lidard {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double same_direction = 5 * rad_per_deg, least_overlap = 0.3;
// Prior standard deviations of what is wrong with ranges: m, and in proportion to them.
constexpr double offset_of_scanner = 0.015, offset_of_ring = 0.010, scale_of_ranges = 0.001;
constexpr double freedom = 5;  // of Student's distribution
constexpr double prior_freedom = 10;
constexpr double least_evidence = 0.04;  // of the evidence that must determine a direction
constexpr double floor_m = 0.0002, floor_rad = 0.001 * rad_per_deg;

Vector2d across(const Vector2d& v) { return {-v.y(), v.x()}; }
Vector2d unit(double angle) { return {std::cos(angle), std::sin(angle)}; }

}  // namespace

WallFit::WallFit(std::vector<Sensor> sensors) : sensors_(std::move(sensors)) {
  for (Sensor& sensor : sensors_) {
    sensor.first_offset = offsets_.size();
    offsets_.resize(offsets_.size() + sensor.seen->views.size(), 0);
    offset_sigma_.resize(offsets_.size(), sensor.seen->is_planar() ? offset_of_scanner : offset_of_ring);
    sensor.scale = offsets_.size();
    offsets_.push_back(0), offset_sigma_.push_back(scale_of_ranges);
  }
}

bool WallFit::find_walls(double gate) {
  walls_.clear(), sightings_.clear();
  struct Candidate {
    std::size_t sensor;
    const Surface* surface;
  };
  std::vector<Candidate> candidates;
  for (std::size_t s = 0; s < sensors_.size(); ++s) {
    for (const Surface& surface : sensors_[s].seen->surfaces) candidates.push_back({s, &surface});
  }
  std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.surface->length() > b.surface->length();
  });
  for (const auto& [s, surface] : candidates) {
    const PlanarPose& pose = sensors_[s].pose;
    const Vector2d middle = pose * surface->middle, normal = pose.turned(surface->normal);
    const double angle = std::atan2(normal.y(), normal.x());
    Wall* nearest = nullptr;
    double least = gate;
    for (Wall& wall : walls_) {
      if (std::abs(std::remainder(angle - wall.angle, two_pi)) > same_direction) continue;
      const Vector2d n = unit(wall.angle);
      const double off = std::abs(n.dot(middle - wall.centre) - wall.offset);
      const double s0 = across(n).dot(middle - wall.centre);
      // The wall's direction is across its normal, as that of a surface is against it.
      const double lowest = std::max(wall.from, s0 - surface->length() / 2),
                   highest = std::min(wall.to, s0 + surface->length() / 2);
      if (off >= least || highest - lowest < least_overlap * std::min(surface->length(), wall.to - wall.from))
        continue;
      nearest = &wall, least = off;
    }
    if (nearest == nullptr) {
      walls_.emplace_back();
      nearest = &walls_.back();
      nearest->centre = middle, nearest->angle = angle;
      nearest->from = -surface->length() / 2, nearest->to = surface->length() / 2;
    }
    sightings_.push_back({s, static_cast<std::size_t>(nearest - walls_.data()),
                          sensors_[s].first_offset + surface->ring, surface});
  }
  std::vector<std::map<std::size_t, double>> seen_by(walls_.size());
  for (const Sighting& sighting : sightings_)
    ++walls_[sighting.wall].seen, ++seen_by[sighting.wall][sighting.sensor];
  for (Sighting& sighting : sightings_) sighting.rings = seen_by[sighting.wall][sighting.sensor];
  for (std::size_t w = 0; w < walls_.size(); ++w) walls_[w].sensors = seen_by[w].size();
  sightings_.erase(std::remove_if(sightings_.begin(), sightings_.end(),
                                  [&](const Sighting& sighting) { return walls_[sighting.wall].seen < 2; }),
                   sightings_.end());
  bool any = false;
  for (Sensor& sensor : sensors_) sensor.shared = 0;
  for (const Sighting& sighting : sightings_) {
    if (walls_[sighting.wall].sensors < 2) continue;
    ++sensors_[sighting.sensor].shared;
    any = true;
  }
  return any;
}

void WallFit::find_held() {
  std::vector<std::vector<LocalLine>> lines(sensors_.size());
  for (const Sighting& sighting : sightings_) {
    if (walls_[sighting.wall].sensors < 2) continue;
    const Sensor& sensor = sensors_[sighting.sensor];
    const Surface& surface = *sighting.surface;
    for (const LocalLine& line : local_lines(sensor.seen->views[surface.ring], surface))
      lines[sighting.sensor].push_back(line);
  }
  for (std::size_t s = 0; s < sensors_.size(); ++s) {
    Sensor& sensor = sensors_[s];
    sensor.held.clear();
    if (lines[s].empty()) {
      for (int i = 0; i < 3; ++i) sensor.held.emplace_back(Vector3d::Unit(i));
      continue;
    }
    sensor.centre.setZero();
    for (const LocalLine& line : lines[s])
      sensor.centre += sensor.pose * line.middle / static_cast<double>(lines[s].size());
    double square = 0, noise = 0;
    for (const LocalLine& line : lines[s]) {
      const double arm =
          sensor.pose.turned(line.normal).dot(across(sensor.pose * line.middle - sensor.centre));
      square += arm * arm / static_cast<double>(lines[s].size());
      noise += line.var_normal / static_cast<double>(lines[s].size());
    }
    sensor.lever = std::max(0.05, std::sqrt(square));
    Eigen::Matrix3d evidence = Eigen::Matrix3d::Zero();
    for (const LocalLine& line : lines[s]) {
      const Vector2d n = sensor.pose.turned(line.normal);
      const Vector3d lever(n.x(), n.y(),
                           n.dot(across(sensor.pose * line.middle - sensor.centre)) / sensor.lever);
      evidence += lever * lever.transpose() / static_cast<double>(lines[s].size());
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> parts(evidence);
    for (int i = 0; i < 3; ++i) {
      if (parts.eigenvalues()[i] - noise < least_evidence)
        sensor.held.emplace_back(parts.eigenvectors().col(i));
    }
  }
}

/// How far a surface is off its wall, m across and rad of slope, and by how much the unknowns change both: at
/// most 3 of the sensor, 2 of its ranges, 2 of the wall.
struct WallFit::Residual {
  double across = 0, slope = 0;
  std::array<Eigen::Index, 7> unknowns{};
  std::array<double, 7> on_across{}, on_slope{};
  std::size_t count = 0;

  void depends_on(Eigen::Index unknown, double by_across, double by_slope) {
    unknowns[count] = unknown, on_across[count] = by_across, on_slope[count] = by_slope, ++count;
  }
};

WallFit::Residual WallFit::residual_of(const Sighting& sighting) const {
  const Sensor& sensor = sensors_[sighting.sensor];
  const Wall& wall = walls_[sighting.wall];
  const Surface& surface = *sighting.surface;
  const Vector2d n = unit(wall.angle), middle = sensor.pose * surface.middle,
                 normal = sensor.pose.turned(surface.normal);
  const double offset = offsets_[sighting.offset], distance = surface.normal.dot(surface.middle);
  Residual residual;
  residual.across = n.dot(middle - wall.centre) - wall.offset + offset * surface.offset_by_range +
                    offsets_[sensor.scale] * distance;
  residual.slope = std::remainder(std::atan2(normal.y(), normal.x()) - wall.angle, two_pi) +
                   offset * surface.slope_by_range;
  if (!sensor.is_fixed) {
    residual.depends_on(sensor.first_unknown, n.x(), 0);
    residual.depends_on(sensor.first_unknown + 1, n.y(), 0);
    residual.depends_on(sensor.first_unknown + 2, n.dot(across(middle - sensor.centre)) / sensor.lever,
                        1 / sensor.lever);
  }
  residual.depends_on(offsets_unknown_ + static_cast<Eigen::Index>(sighting.offset), surface.offset_by_range,
                      surface.slope_by_range);
  residual.depends_on(offsets_unknown_ + static_cast<Eigen::Index>(sensor.scale), distance, 0);
  residual.depends_on(wall.unknown, -1, 0);
  residual.depends_on(wall.unknown + 1, across(n).dot(middle - wall.centre), -1);
  return residual;
}

/// The normal equations of a step, and what the deviations need.
struct WallFit::Equations {
  explicit Equations(Eigen::Index unknowns)
      : levers(Eigen::MatrixXd::Zero(unknowns, unknowns)), pulls(Eigen::VectorXd::Zero(unknowns)) {}

  Eigen::MatrixXd levers;
  Eigen::VectorXd pulls;
  double chi_square = 0, residuals = 0;
  /// Of the residuals of all rings of a sensor that see a wall.
  struct Mean {
    double across = 0, across_weight = 0, slope = 0, slope_weight = 0, bias_slope = 0;
  };
  std::map<std::pair<std::size_t, std::size_t>, Mean> means;  // by wall and sensor
};

WallFit::Equations WallFit::number_unknowns() {
  Eigen::Index unknowns = 0;
  for (Sensor& sensor : sensors_) {
    sensor.first_unknown = unknowns;
    if (!sensor.is_fixed) unknowns += 3;
  }
  offsets_unknown_ = unknowns;
  unknowns += static_cast<Eigen::Index>(offsets_.size());
  for (Wall& wall : walls_) {
    wall.unknown = unknowns;
    if (wall.seen >= 2) unknowns += 2;
  }
  return Equations(unknowns);
}

/// What is known of the offsets beforehand, and directions that stay as they are.
void WallFit::add_priors(Equations& equations) {
  for (std::size_t i = 0; i < offsets_.size(); ++i) {
    const Eigen::Index at = offsets_unknown_ + static_cast<Eigen::Index>(i);
    const double weight = 1 / (offset_sigma_[i] * offset_sigma_[i]);
    equations.levers(at, at) += weight, equations.pulls[at] -= weight * offsets_[i];
    unlikeliness_ += weight * offsets_[i] * offsets_[i];
  }
  for (const Sensor& sensor : sensors_) {
    if (sensor.is_fixed) continue;
    for (const Vector3d& held : sensor.held)
      equations.levers.block<3, 3>(sensor.first_unknown, sensor.first_unknown) +=
          1e14 * held * held.transpose();
  }
}

void WallFit::add_sightings(const Bias& bias, Equations& equations) const {
  for (const Sighting& sighting : sightings_) {
    const Surface& surface = *sighting.surface;
    const Residual residual = residual_of(sighting);
    const double length = surface.length();
    const double bias_across = bias.across * bias.across,
                 bias_slope = 12 * bias.turning * bias.turning / (length * length);
    // A residual is as large as its own variance says; together, those of all rings are as one bias.
    const double own_across = surface.var_offset + bias_across, own_slope = surface.var_slope + bias_slope;
    const double var_across = surface.var_offset + sighting.rings * bias_across,
                 var_slope = surface.var_slope + sighting.rings * bias_slope;
    const double chi =
        residual.across * residual.across / own_across + residual.slope * residual.slope / own_slope;
    const double trust = (freedom + 2) / (freedom + chi);
    equations.chi_square += trust * chi / sighting.rings;
    Equations::Mean& mean = equations.means[{sighting.wall, sighting.sensor}];
    mean.across += residual.across / surface.var_offset, mean.across_weight += 1 / surface.var_offset;
    mean.slope += residual.slope / surface.var_slope, mean.slope_weight += 1 / surface.var_slope;
    mean.bias_slope += bias_slope / sighting.rings;
    equations.residuals += 2 / sighting.rings;
    const auto& [unknowns, on_across, on_slope] =
        std::tie(residual.unknowns, residual.on_across, residual.on_slope);
    for (std::size_t i = 0; i < residual.count; ++i) {
      for (std::size_t j = 0; j < residual.count; ++j)
        equations.levers(unknowns[i], unknowns[j]) +=
            trust * (on_across[i] * on_across[j] / var_across + on_slope[i] * on_slope[j] / var_slope);
      equations.pulls[unknowns[i]] -=
          trust * (on_across[i] * residual.across / var_across + on_slope[i] * residual.slope / var_slope);
    }
  }
}

void WallFit::step(const Bias& bias, bool moves) {
  Equations equations = number_unknowns();
  unlikeliness_ = 0;
  add_priors(equations);
  add_sightings(bias, equations);
  for (const auto& [wall_and_sensor, mean] : equations.means) {
    const double var_across = 1 / mean.across_weight + bias.across * bias.across,
                 var_slope = 1 / mean.slope_weight + mean.bias_slope;
    const double chi = std::pow(mean.across / mean.across_weight, 2) / var_across +
                       std::pow(mean.slope / mean.slope_weight, 2) / var_slope;
    unlikeliness_ += std::log(var_across * var_slope) + (freedom + 2) * std::log1p(chi / freedom);
  }
  const Eigen::Index unknowns = equations.pulls.size();
  const double spare = std::max(
      1.0, equations.residuals - static_cast<double>(unknowns - static_cast<Eigen::Index>(offsets_.size())));
  chi_square_ = equations.chi_square / spare;
  const Eigen::LDLT<Eigen::MatrixXd> solver(equations.levers);
  unlikeliness_ += solver.vectorD().array().abs().max(1e-300).log().sum();
  // The offsets of rings against each other do not show the bias, which the rings have in common.
  for (const Sensor& sensor : sensors_) {
    const std::size_t rings = sensor.seen->views.size();
    const auto first = offsets_unknown_ + static_cast<Eigen::Index>(sensor.first_offset);
    const auto own = equations.levers.diagonal().segment(first, static_cast<Eigen::Index>(rings));
    unlikeliness_ -= (1 - 1 / static_cast<double>(rings)) * own.array().log().sum();
  }
  if (moves) {
    const Eigen::VectorXd change = solver.solve(equations.pulls);
    if (change.allFinite()) apply(change);
  } else {
    inverse_ = solver.solve(Eigen::MatrixXd::Identity(unknowns, offsets_unknown_));
    scale_ = std::max(1.0, (prior_freedom + equations.chi_square) / (prior_freedom + spare));
  }
}

void WallFit::apply(const Eigen::VectorXd& change) {
  for (Sensor& sensor : sensors_) {
    if (!sensor.is_fixed) sensor.move(change.segment<3>(sensor.first_unknown));
  }
  for (std::size_t i = 0; i < offsets_.size(); ++i)
    offsets_[i] += change[offsets_unknown_ + static_cast<Eigen::Index>(i)];
  for (Wall& wall : walls_) {
    if (wall.seen < 2) continue;
    wall.offset += change[wall.unknown];
    wall.angle += change[wall.unknown + 1];
  }
}

void WallFit::Sensor::move(const Vector3d& change) {
  const double turn = change[2] / lever;
  const Vector2d to = centre + PlanarPose{0, 0, turn}.turned(pose.position() - centre) + change.head<2>();
  pose = {to.x(), to.y(), std::remainder(pose.yaw + turn, two_pi)};
}

Vector3d WallFit::Sensor::pose_change(const Vector3d& change) const {
  const Vector2d arm = across(pose.position() - centre) / lever;
  return {change[0] + change[2] * arm.x(), change[1] + change[2] * arm.y(), change[2] / lever};
}

void WallFit::refine(const Bias& bias, int steps) {
  for (int i = 0; i < steps; ++i) step(bias, true);
  step(bias, false);
}

Eigen::Matrix3d WallFit::covariance(std::size_t s) const {
  const Sensor& sensor = sensors_[s];
  if (sensor.is_fixed || inverse_.size() == 0) return Eigen::Matrix3d::Zero();
  // From moves about the centre to those of the pose.
  Eigen::Matrix3d to_pose;
  for (int i = 0; i < 3; ++i) to_pose.col(i) = sensor.pose_change(Vector3d::Unit(i));
  const Eigen::Matrix3d own = scale_ * inverse_.block<3, 3>(sensor.first_unknown, sensor.first_unknown);
  Eigen::Matrix3d result = to_pose * own * to_pose.transpose();
  for (int i = 0; i < 2; ++i) result(i, i) += floor_m * floor_m;
  result(2, 2) += floor_rad * floor_rad;
  return result;
}

}  // namespace lidard
