// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/beam_rays.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace lidard {
namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double twice_area(const std::vector<Eigen::Vector2d>& v) {
  double sum = 0;
  for (std::size_t i = 0; i < v.size(); ++i) sum += cross(v[i], v[(i + 1) % v.size()]);
  return sum;
}

}  // namespace

Footprint::Footprint(std::vector<Eigen::Vector2d> vertices) : vertices_(std::move(vertices)) {
  if (vertices_.size() < 3) vertices_.clear();
  if (twice_area(vertices_) < 0) std::reverse(vertices_.begin(), vertices_.end());
}

bool Footprint::contains(const Eigen::Vector2d& point) const {
  // The winding number, since the padded sides of a narrow slit overlap.
  int turns = 0;
  for (std::size_t i = 0, j = vertices_.size() - 1; i < vertices_.size(); j = i++) {
    const Eigen::Vector2d& a = vertices_[j];
    const Eigen::Vector2d& b = vertices_[i];
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const bool is_right = point.x() < (b.x() - a.x()) * (point.y() - a.y()) / (b.y() - a.y()) + a.x();
    if (is_right) turns += b.y() > a.y() ? 1 : -1;
  }
  return turns > 0;
}

std::vector<Footprint::Crossing> Footprint::crossings(const Eigen::Vector2d& origin,
                                                      const Eigen::Vector2d& direction) const {
  std::vector<double> borders = {0};
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const Eigen::Vector2d a = vertices_[i] - origin;
    const Eigen::Vector2d edge = vertices_[(i + 1) % vertices_.size()] - vertices_[i];
    const double slope = cross(direction, edge);
    if (std::abs(slope) < 1e-12) continue;
    const double along_edge = cross(a, direction) / slope;
    const double along_ray = cross(a, edge) / slope;
    if (along_edge >= 0 && along_edge <= 1 && along_ray >= 0) borders.push_back(along_ray);
  }
  std::sort(borders.begin(), borders.end());
  std::vector<Crossing> pieces;
  for (std::size_t i = 1; i < borders.size(); ++i) {
    const double in = borders[i - 1], out = borders[i];
    // A corner is a border twice.
    if (out - in < 1e-9 || !contains(origin + (in + out) / 2 * direction)) continue;
    if (!pieces.empty() && in - pieces.back().out < 1e-9)
      pieces.back().out = out;
    else
      pieces.push_back({in, out});
  }
  return pieces;
}

Footprint Footprint::padded(double margin) const {
  std::vector<Eigen::Vector2d> moved;
  const std::size_t n = vertices_.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector2d before = (vertices_[i] - vertices_[(i + n - 1) % n]).normalized();
    const Eigen::Vector2d after = (vertices_[(i + 1) % n] - vertices_[i]).normalized();
    const Eigen::Vector2d normal_before(before.y(), -before.x());
    const Eigen::Vector2d normal_after(after.y(), -after.x());
    // The corner where both moved edges meet lies along the sum of their normals; at a spike that would be
    // far away, so it is cut at four margins.
    const Eigen::Vector2d sum = normal_before + normal_after;
    const double length = std::min(2 / std::max(sum.squaredNorm(), 1e-9), 4 / std::max(sum.norm(), 1e-9));
    moved.push_back(vertices_[i] + margin * length * sum);
  }
  return Footprint(std::move(moved));
}

Footprint Footprint::transformed(const Pose& pose) const {
  std::vector<Eigen::Vector2d> moved;
  for (const auto& v : vertices_) moved.push_back((pose * Eigen::Vector3d(v.x(), v.y(), 0)).head<2>());
  return Footprint(std::move(moved));
}

namespace {

constexpr float nowhere = std::numeric_limits<float>::infinity();
// A scanner may stand a little inside the outline; a crossing shorter than this does not block its beams.
constexpr double housing_m = 0.5;
// The body shrinks by this, so that a beam that starts on an edge and grazes it does not enter.
constexpr double graze_m = 0.002;

/// True if a beam runs into the body. A narrow strip of outline in front of a scanner on the border does not
/// block.
bool is_blocked(const std::vector<Footprint::Crossing>& body) {
  if (body.empty() || body.front().in <= 0) return false;
  return body.front().in > Footprint::margin_m || body.back().out - body.front().in > housing_m;
}

/// First and last range at which a beam that begins at height `from` and climbs `slope` per m is in the band;
/// the last one is below the first one if it never is.
std::pair<float, float> clip(double from, double slope, HeightBand band) {
  if (std::abs(slope) < 1e-9) return {0.0F, from >= band.min && from <= band.max ? nowhere : -1.0F};
  const double at_min = (band.min - from) / slope;
  const double at_max = (band.max - from) / slope;
  return {static_cast<float>(std::max(0.0, std::min(at_min, at_max))),
          static_cast<float>(std::max(at_min, at_max))};
}

}  // namespace

bool BeamRays::fits(const PlanarScan& scan, const Pose& output_from_sensor) const {
  return size() == scan.beams && angle_min == static_cast<double>(scan.angle_min) &&
         increment == static_cast<double>(scan.angle_increment) && wave == scan.wave &&
         pose.matrix() == output_from_sensor.matrix();
}

void BeamRays::build(const PlanarScan& scan, const Pose& output_from_sensor, const Footprint& footprint,
                     HeightBand band) {
  pose = output_from_sensor;
  angle_min = static_cast<double>(scan.angle_min);
  increment = static_cast<double>(scan.angle_increment);
  wave = scan.wave;
  for (auto* list :
       {&x, &y, &z, &level, &cosine, &sine, &own_begin, &own_end, &blocked_at, &band_begin, &band_end})
    list->clear();
  from_inside.clear();
  direction.clear();
  pockets_.clear();
  const Footprint body = footprint.padded(-graze_m);
  const Footprint margin = footprint.padded(Footprint::margin_m);
  for (std::size_t i = 0; i < scan.beams; ++i) {
    add_beam(wave.bent(angle_min + static_cast<double>(i) * increment), body, margin, band);
  }
}

void BeamRays::add_beam(double angle, const Footprint& body, const Footprint& margin, HeightBand band) {
  const Eigen::Vector3d ray = pose.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0);
  const Eigen::Vector2d origin = pose.translation().head<2>();
  direction.push_back(ray);
  x.push_back(static_cast<float>(ray.x()));
  y.push_back(static_cast<float>(ray.y()));
  z.push_back(static_cast<float>(ray.z()));
  level.push_back(static_cast<float>(ray.head<2>().norm()));
  cosine.push_back(static_cast<float>(std::cos(angle)));
  sine.push_back(static_cast<float>(std::sin(angle)));
  const auto own = margin.crossings(origin, ray.head<2>());
  own_begin.push_back(own.empty() ? nowhere : static_cast<float>(own.front().in));
  own_end.push_back(own.empty() ? nowhere : static_cast<float>(own.back().out));
  for (std::size_t i = 1; i < own.size(); ++i) {
    pockets_.push_back(
        {own_begin.size() - 1, static_cast<float>(own[i - 1].out), static_cast<float>(own[i].in)});
  }
  const auto blocked = body.crossings(origin, ray.head<2>());
  blocked_at.push_back(is_blocked(blocked) ? static_cast<float>(blocked.front().in) : nowhere);
  const auto [begin, end] = clip(pose.translation().z(), ray.z(), band);
  band_begin.push_back(begin);
  band_end.push_back(end);
  from_inside.push_back(!blocked.empty() && blocked.front().in <= 0 && blocked.back().out > housing_m ? 1
                                                                                                      : 0);
}

float BeamRays::own_piece(std::size_t beam, float range) const {
  float from = own_begin[beam];
  const auto before = [](const Pocket& pocket, std::size_t of) { return pocket.beam < of; };
  for (auto it = std::lower_bound(pockets_.begin(), pockets_.end(), beam, before);
       it != pockets_.end() && it->beam == beam && range > it->begin; ++it) {
    if (range < it->end) return nowhere;
    from = it->end;
  }
  return from;
}

}  // namespace lidard
