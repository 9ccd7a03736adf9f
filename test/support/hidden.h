// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/frames/scan_grid.h"
#include "test/sim/world/flat_world.h"
#include "test/support/merge_score.h"
#include "test/support/yard.h"

namespace lidard::sim {

/// What stands in an open yard, made to be missed. `posts`: in sight of the sensors. `behind_rods`: each post
/// behind rods that hide it from every sensor. `combs`: rows of posts with gaps of their own width. `slits`:
/// pairs of walls with a slit between them. `low`: boxes that end near the height of the plane. `low_walls`:
/// thin walls that do, mostly square to the beams.
enum class Hiding : std::uint8_t { posts, behind_rods, combs, slits, low, low_walls };

/// How the yard is looked at.
struct HidingCase {
  const char* name;
  Hiding hiding;
  bool from_cloud;     ///< a virtual scan of one lidar on a mast; else two scanners at the front are merged
  double source_deg;   ///< between the beams of a scanner, the columns of a lidar
  std::size_t beams;   ///< of the output
  double noise;        ///< one standard deviation of a range, m
  Eigen::Vector3d at;  ///< of the output's frame, vehicle frame, m
  double range_max;    ///< m, of the output
  std::size_t rings = 16;  ///< of the lidar, from -15 to 15 degrees
};
const std::vector<HidingCase>& hiding_cases();

/// An upright box.
struct Thing {
  Eigen::Vector2d at, half;  ///< m
  double yaw = 0;
  double height = 2;  ///< m
};

/// A yard, its measurement and the truth for each beam of the output.
struct HidingScene {
  std::vector<Thing> things;
  std::vector<Claim> strict, safety;
  /// m, over the whole width of each beam: to what it meets, and to where it would leave that again;
  /// infinite: something passes.
  std::vector<double> nearest, farthest;
  std::vector<char> open;  ///< nothing within reach, and some sensor sees the whole way
};
HidingScene make_hiding_scene(const HidingCase& set_up, std::uint64_t seed);

/// Counts over beams whose whole width meets something within reach, and over open beams.
struct HidingScore {
  std::uint64_t blocked = 0, right = 0, falsely_free = 0, seen_through = 0, phantom = 0, unknown = 0;
  std::uint64_t open = 0, open_free = 0, open_hit = 0;
  void add(const HidingScore& other);
};
HidingScore judge_hiding(const HidingCase& set_up, const HidingScene& scene,
                         const std::vector<Claim>& claims);

}  // namespace lidard::sim
