// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/frames/cloud.h"
#include "core/frames/scan.h"

namespace lidard {

/// The median of a beam of a sensor that stands, seen from above: in the level frame of the sensor, which has
/// the origin of the sensor, z up, and the sensor's x axis above its own.
struct StillBeam {
  Eigen::Vector2d point{0, 0};  ///< m; without a hit a unit vector along the beam
  double range = 0;             ///< m from above; infinity: nothing in reach; NaN: not known
  double height = 0;            ///< m above the sensor
  double sigma = 0;             ///< m, standard deviation of `range`

  bool is_hit() const { return range > 0 && range < 1e9; }
};

/// What one laser of a sensor sees, beams by growing or falling azimuth.
struct StillView {
  std::vector<StillBeam> beams;
  double step = 0;       ///< rad between neighbouring beams
  std::size_t ring = 0;  ///< of a multi-plane lidar
};

/// Sets the standard deviations of the beams of a single sweep, from how ranges of neighbouring beams
/// differ; `scratch` keeps its memory.
void estimate_noise(StillView& view, std::vector<double>& scratch);

/// Collects what a sensor measures while the vehicle stands. Each beam becomes the median of its returns, so
/// that what moves through the view leaves no trace.
class StillScans {
 public:
  /// The grids of all scans must agree; others, and those without beams, are not added. False: not added.
  bool add(const PlanarScan& scan);
  /// Returns of a multi-plane lidar by ring and azimuth (steps of 0.2 degrees). Rings from 256 on are left
  /// out.
  void add(const Cloud& cloud);
  std::size_t frames() const { return frames_; }
  bool is_cloud() const { return cloud_frames_ > 0; }
  /// All returns as points of the sensor's frame, medians.
  std::vector<Eigen::Vector3d> points() const;
  /// The views in the level frame; `tilt` turns coordinates of the sensor to it (roll and pitch alone).
  std::vector<StillView> views(const Eigen::Matrix3d& tilt) const;

 private:
  /// Returns of one beam, the first `most` of them.
  struct Samples {
    static constexpr std::size_t most = 64;
    std::vector<float> ranges;
    std::size_t seen = 0, nothing = 0;
    Eigen::Vector3f ray{0, 0, 0};  // sum of unit vectors
    void add(float range, const Eigen::Vector3f& along);
    /// The median where there are `enough` returns, infinity where as often there was none, else NaN;
    /// `sigma`: its standard deviation.
    double median(double enough, double& sigma) const;
  };
  double enough() const;
  /// How many bins of a multi-plane lidar lie from one beam of the ring to the next.
  std::size_t stride(const std::vector<Samples>& ring) const;

  std::size_t frames_ = 0, cloud_frames_ = 0;
  double angle_min_ = 0, step_ = 0;
  std::vector<std::vector<Samples>> rings_;
};

}  // namespace lidard
