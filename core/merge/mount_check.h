// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/base/time.h"
#include "core/evidence/placed_scan.h"

namespace lidard {

/// Comparison of the surfaces that two sources both see, smoothed.
struct OverlapState {
  std::size_t first = 0, second = 0;  ///< the sources
  double beams = 0;                   ///< that show both the same surface, in one look
  double median = 0;                  ///< m, range of the first less that of the second, along the beam
  double mad = 0;                     ///< m, median absolute deviation from the median
  /// What to add to the mount of `second`, in the output frame: yaw (rad), x, y (m).
  Eigen::Vector3d correction{0, 0, 0};
  /// False for components that the surfaces do not determine, such as the position along a corridor.
  std::array<bool, 3> determined{false, false, false};
  double shift = 0;  ///< m by which the correction moves the surfaces, root mean square
  /// The median or the shift exceeds the tolerance and three times its statistical error.
  bool misaligned = false;
  std::optional<Stamp> since;  ///< the first look that found them misaligned
};

/// Checks whether sources agree on the surfaces that both see. A disagreement means that a configured mount
/// is wrong. Compares straight pieces of surface along beams from the output frame's origin.
class MountCheck {
 public:
  /// `tolerance`, m: smaller differences are accepted.
  explicit MountCheck(std::size_t sources, double tolerance = 0.02);

  /// True when the next comparison is due, a few times per second.
  bool is_due(Stamp stamp) const;
  /// Compares the newest sweeps of the sources (nullptr: none), measured from `places` in the output frame.
  /// `deskewed`: the sweeps are deskewed to one instant. Otherwise they are compared only while every
  /// source's own view shows that the vehicle stands, since motion between two sweeps looks like a wrong
  /// mount. Resets if the stamp jumps back.
  void look(Stamp stamp, const std::vector<const PlacedScan*>& sweeps,
            const std::vector<Eigen::Vector2d>& places, bool deskewed);
  void reset();

  /// One per pair of sources; `beams` is 0 while they have no surface in common.
  const std::vector<OverlapState>& pairs() const { return states_; }

 private:
  /// A straight piece of surface where a beam meets it.
  struct Facet {
    float range = 0;               // m from the output's origin; 0: none
    Eigen::Vector2f normal{0, 0};  // away from the surface, towards the source
  };
  /// A beam that shows a pair the same surface.
  struct Common {
    Eigen::Vector3d lever;  // how yaw, x and y of the second source move the surface along its normal
    double across;          // m between both surfaces, along the normal
    double along;           // m, along the beam
  };
  /// Sums with slow decay.
  struct Memory {
    double weight = 0, beams = 0, median = 0, mad = 0, rest = 0;
    double evidence = 0;  // of beams
    bool since_knock = false;
    Eigen::Matrix3d levers = Eigen::Matrix3d::Zero();
    Eigen::Vector3d pulls = Eigen::Vector3d::Zero();
  };
  bool stands(std::size_t source);
  void see(const PlacedScan& sweep, const Eigen::Vector2d& place, std::vector<Facet>& facets);
  bool fit(const PlacedScan& sweep, std::size_t beam, Eigen::Vector2f& middle, Eigen::Vector2f& normal) const;
  void draw(const Eigen::Vector2f& p, const Eigen::Vector2f& q, const Eigen::Vector2f& middle,
            const Eigen::Vector2f& normal, std::vector<Facet>& facets) const;
  void compare(const std::vector<Facet>& first, const std::vector<Facet>& second,
               const Eigen::Vector2d& place);
  void learn(Memory& memory);
  void remember(double kept, Memory& memory);
  void judge(const Memory& memory, OverlapState& state) const;
  static void date_knock(Stamp stamp, Memory& memory, OverlapState& state);
  template <typename Value>
  double median_of(Value value);

  double tolerance_;
  std::optional<Stamp> last_look_;
  std::vector<std::vector<Facet>> facets_;  // per source and beam
  std::vector<std::vector<Facet>> before_;  // facets_ of the previous comparison
  std::vector<Eigen::Vector2f> rays_;
  std::vector<Common> common_;
  std::vector<double> sorted_;
  std::vector<Memory> memories_;
  std::vector<OverlapState> states_;
};

}  // namespace lidard
