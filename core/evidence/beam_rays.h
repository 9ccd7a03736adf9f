// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <limits>
#include <vector>

#include "core/base/pose.h"
#include "core/frames/scan.h"
#include "core/frames/scan_grid.h"

namespace lidard {

/// Outline of the vehicle, a simple polygon in the xy plane of some frame, m.
class Footprint {
 public:
  /// A piece of a ray inside the outline, m along the ray. `in` is 0 if the ray begins inside.
  struct Crossing {
    double in = 0;
    double out = 0;
  };

  /// Returns within this distance of the outline belong to the vehicle: mirrors, cables, an outline drawn a
  /// little too small.
  static constexpr double margin_m = 0.05;

  Footprint() = default;
  /// Vertices in order, clockwise or counter-clockwise; fewer than three vertices make an empty outline.
  explicit Footprint(std::vector<Eigen::Vector2d> vertices);

  bool empty() const { return vertices_.empty(); }
  const std::vector<Eigen::Vector2d>& vertices() const { return vertices_; }
  bool contains(const Eigen::Vector2d& point) const;
  /// The pieces of the ray inside the outline, in order; none if it only touches or misses the outline,
  /// several only if the outline is concave.
  std::vector<Crossing> crossings(const Eigen::Vector2d& origin, const Eigen::Vector2d& direction) const;
  /// Every edge moved outward by `margin` m (inward if negative).
  Footprint padded(double margin) const;
  /// The outline in another frame; heights are dropped.
  Footprint transformed(const Pose& pose) const;

 private:
  std::vector<Eigen::Vector2d> vertices_;  // counter-clockwise
};

/// The beams of one scanner in an output frame. They are computed once and stay valid while mount and beams
/// stay the same.
class BeamRays {
 public:
  /// True if the rays were built for this scanner at this pose.
  bool fits(const PlanarScan& scan, const Pose& output_from_sensor) const;
  /// Builds the rays; `footprint` is the vehicle's outline, `band` the heights that count, in the output
  /// frame.
  void build(const PlanarScan& scan, const Pose& output_from_sensor, const Footprint& footprint,
             HeightBand band);

  std::size_t size() const { return x.size(); }
  /// Where the piece of the vehicle begins in which a return of the beam lies, m; infinite if it lies in
  /// none.
  float own_from(std::size_t beam, float range) const {
    const bool is_own = range >= own_begin[beam] && range <= own_end[beam];
    if (!is_own) return std::numeric_limits<float>::infinity();
    return pockets_.empty() ? own_begin[beam] : own_piece(beam, range);
  }

  Pose pose = Pose::Identity();            ///< output_from_sensor
  double angle_min = 0;                    ///< rad, sensor frame
  double increment = 0;                    ///< rad
  AngleWave wave;                          ///< of the beams
  std::vector<Eigen::Vector3d> direction;  ///< in the output frame, per m of range
  std::vector<float> x, y, z;              ///< the components of `direction`
  std::vector<float> level;                ///< m in the output's plane per m of range
  std::vector<float> cosine;               ///< in the sensor frame
  std::vector<float> sine;
  /// Returns in [own_begin, own_end] hit the vehicle or lie between two of its parts, which own_from()
  /// distinguishes; inf: none.
  std::vector<float> own_begin, own_end;
  std::vector<float> blocked_at;  ///< range where the beam runs into the body from outside; inf: nowhere
  std::vector<float> band_begin;  ///< ranges in [band_begin, band_end] are at heights that count
  std::vector<float> band_end;    ///< below band_begin: none of them
  std::vector<char> from_inside;  ///< the beam begins inside and leaves the vehicle beyond a housing's depth

 private:
  /// Where a beam leads out of the vehicle and into it again, m: between the forks of a truck.
  struct Pocket {
    std::size_t beam;
    float begin, end;
  };
  std::vector<Pocket> pockets_;  // by beam
  float own_piece(std::size_t beam, float range) const;
  void add_beam(double angle, const Footprint& body, const Footprint& margin, HeightBand band);
};

}  // namespace lidard
