// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mounts/planar_pose.h"
#include "core/mounts/surroundings.h"

namespace lidard {

/// The least-squares problem of mounts: unknown are the poses of the sensors, the walls, and an offset of the
/// ranges per laser. A pose moves by (x, y, turn * lever) about `centre`, so that all three are lengths.
class WallFit {
 public:
  struct Sensor {
    const Surroundings* seen;
    PlanarPose pose;
    bool is_fixed = false;
    Eigen::Vector2d centre{0, 0};
    double lever = 1;
    std::vector<Eigen::Vector3d> held;  ///< directions that stay as they are
    std::size_t shared = 0;             ///< surfaces on walls that another sensor sees too
    Eigen::Index first_unknown = 0;
    std::size_t first_offset = 0, scale = 0;  ///< of its lasers and of their ranges, among the offsets

    /// Moves the pose by (x, y, turn * lever) about the centre.
    void move(const Eigen::Vector3d& change);
    /// The change of x, y and yaw by such a move, if it is small.
    Eigen::Vector3d pose_change(const Eigen::Vector3d& change) const;
  };

  explicit WallFit(std::vector<Sensor> sensors);
  /// Joins surfaces to walls, nearer than `gate` (m); true if any wall is shared by two sensors.
  bool find_walls(double gate);
  /// Sets centre, lever and held directions from what the shared surfaces determine.
  void find_held();
  /// What the returns of a surface have in common as error: m across it, and m by which it turns the surface
  /// (between its ends).
  struct Bias {
    double across, turning;
  };
  /// Gauss-Newton steps with this bias per surface.
  void refine(const Bias& bias, int steps);
  /// After refine(): chi-square per degree of freedom, and how unlikely the residuals are with that bias
  /// (-2 log of the evidence).
  double chi_square() const { return chi_square_; }
  double unlikeliness() const { return unlikeliness_; }
  /// Of (x, y, yaw) of a sensor after refine().
  Eigen::Matrix3d covariance(std::size_t sensor) const;
  double offset_of(std::size_t sensor) const { return offsets_[sensors_[sensor].first_offset]; }
  const std::vector<Sensor>& sensors() const { return sensors_; }
  Sensor& sensor(std::size_t i) { return sensors_[i]; }

 private:
  struct Wall {
    Eigen::Vector2d centre{0, 0};
    double angle = 0;   // rad, of the normal
    double offset = 0;  // m along the normal from the centre
    double from = 0, to = 0;
    std::size_t seen = 0, sensors = 0;
    Eigen::Index unknown = 0;  // of the offset; that of the angle follows
  };
  struct Sighting {
    std::size_t sensor, wall, offset;
    const Surface* surface;
    double rings = 1;  // of the sensor that see the wall: its bias they have in common
  };
  struct Residual;
  struct Equations;
  Residual residual_of(const Sighting& sighting) const;
  Equations number_unknowns();
  void add_priors(Equations& equations);
  void add_sightings(const Bias& bias, Equations& equations) const;
  void apply(const Eigen::VectorXd& change);
  void step(const Bias& bias, bool moves);

  std::vector<Sensor> sensors_;
  std::vector<Wall> walls_;
  std::vector<Sighting> sightings_;
  std::vector<double> offsets_, offset_sigma_;
  Eigen::Index offsets_unknown_ = 0;  // the first one
  Eigen::MatrixXd inverse_;
  double scale_ = 1, chi_square_ = 0, unlikeliness_ = 0;
};

}  // namespace lidard
