// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/time.h"
#include "core/evidence/placed_scan.h"
#include "core/mounts/surface_match.h"
#include "core/mounts/surroundings.h"

namespace lidard {

/// How the mounts of two sources differ from their configuration, against each other.
struct MountDifference {
  std::size_t first = 0, second = 0;  ///< the sources
  std::size_t surfaces = 0;           ///< that both see, in the newest comparison
  /// What to add to the mount of `second`, in the output frame: x, y (m), yaw (rad).
  Eigen::Vector3d correction{0, 0, 0};
  Eigen::Vector3d sigma{0, 0, 0};  ///< standard deviations of a comparison
  /// False for components that the surfaces do not determine, such as the position along a corridor.
  std::array<bool, 3> determined{false, false, false};
  /// The correction exceeds the tolerance beyond chance, since then; the first comparison that showed it.
  std::optional<Stamp> since{};
  bool is_wrong = false;  ///< it has exceeded the tolerance for 5 s
  /// Since then no surface of one is where the other one looks, though their fields of view overlap.
  std::optional<Stamp> astray_since{};
  bool is_astray = false;  ///< for 5 s; no correction can be named
};

/// Compares the upright surfaces that sources see while the vehicle is in operation, as `lidard calibrate`
/// does with a parked one. A lasting difference means that a mount is not as configured.
class MountCheck {
 public:
  explicit MountCheck(std::size_t sources);

  /// True when the next comparison is due, a few times per second.
  bool is_due(Stamp stamp) const;
  /// Compares the newest sweeps of the sources (nullptr: none), measured from `viewpoints` in the output
  /// frame. `deskewed`: the sweeps are deskewed to one instant. Otherwise they are compared only while each
  /// source's own view shows that the vehicle stands, since motion between two sweeps looks like a wrong
  /// mount. Resets if the stamp jumps back.
  void update(Stamp stamp, const std::vector<const PlacedScan*>& sweeps,
              const std::vector<Eigen::Vector2d>& viewpoints, bool deskewed);
  void reset();

  /// One per pair of sources; `surfaces` is 0 while they have none in common.
  const std::vector<MountDifference>& pairs() const { return pairs_; }
  /// The source whose mount is wrong, if the others agree with each other.
  std::optional<std::size_t> wrong_source() const;

 private:
  /// Sums of comparisons, with slow decay.
  struct Memory {
    Stamp begin{};
    std::size_t comparisons = 0;
    double weight = 0;                                 // of them, decayed as the sums are
    Eigen::Matrix3d levers = Eigen::Matrix3d::Zero();  // information of the corrections
    Eigen::Vector3d pulls = Eigen::Vector3d::Zero();   // information times correction
    double square = 0;                                 // of the corrections, in their deviations
    void add(const MatchedPose& look, const Eigen::Vector3d& off, Stamp stamp, double kept);
  };
  struct Source : Surroundings {  // in the newest comparison
    Source() { views.resize(1); }
    std::vector<Surface> before;  // the surfaces of the comparison before
    bool stands() const;
  };
  void find_source(const PlacedScan& sweep, const Eigen::Vector2d& viewpoint, Source& source);
  MatchedPose match(std::size_t pair, const PlanarPose& configured, Stamp stamp);
  void compare(std::size_t pair, const Eigen::Vector2d& offset, Stamp stamp, double kept);
  static void assess(const Memory& memory, MountDifference& pair);

  std::optional<Stamp> updated_;
  std::vector<Source> sources_;
  std::vector<double> scratch_;
  std::vector<MountDifference> pairs_;
  std::vector<Memory> memories_, changed_;  // by pair: what holds, and what differs from it
  /// By pair: a pose far from the configured one that fits better, and when the next one is searched.
  std::vector<std::pair<std::optional<PlanarPose>, Stamp>> far_;
};

}  // namespace lidard
