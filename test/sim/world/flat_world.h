// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "core/base/pose.h"
#include "core/frames/scan.h"
#include "test/sim/world/motion.h"
#include "test/sim/world/rng.h"

namespace lidard::sim {

/// A world of upright walls seen from above, m: rays meet it exactly, so it is the truth for scans.
class FlatWorld {
 public:
  void add_wall(const Eigen::Vector2d& a, const Eigen::Vector2d& b);
  /// A closed box around `center` with half sides `half`, turned by `yaw` rad.
  void add_box(const Eigen::Vector2d& center, const Eigen::Vector2d& half, double yaw);
  /// m to the first wall in direction `angle` (rad); infinite if there is none.
  double cast(const Eigen::Vector2d& origin, double angle) const;
  /// m from a point to the nearest wall; infinite if there is none.
  double distance(const Eigen::Vector2d& point) const;
  /// The same world seen from a frame at `center` turned by `yaw`.
  FlatWorld seen_from(const Eigen::Vector2d& center, double yaw) const;

 private:
  struct Wall {
    Eigen::Vector2d a, b;
  };
  std::vector<Wall> walls_;
};

/// A level single-plane scanner.
struct FlatScanner {
  Eigen::Vector2d at{0, 0};
  double yaw = 0;                      ///< rad
  double field = 4.71238898038468986;  ///< rad, 270 degrees
  double increment = 0;                ///< rad
  double range_max = 25;               ///< m
  double noise = 0;                    ///< one standard deviation, m
  double spot = 0;  ///< rad, half the width of the spot that can touch two surfaces; 0: no veil points

  Pose pose() const { return make_pose({at.x(), at.y(), 0}, {0, 0, yaw}); }
  /// True if `point` is in its field and range and nothing is in between (2 cm of slack).
  bool sees(const FlatWorld& world, const Eigen::Vector2d& point) const;
  /// What it measures; the draws from `rng` depend on the world alone.
  void measure(const FlatWorld& world, Rng& rng, PlanarScan& scan) const;
  /// The same on a vehicle that drives: `place` tells where in the world it is when a beam is measured.
  void measure(const FlatWorld& world, const std::function<Pose2(std::size_t)>& place, Rng& rng,
               PlanarScan& scan) const;
};

}  // namespace lidard::sim
