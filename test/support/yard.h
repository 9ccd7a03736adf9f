// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/evidence/beam_rays.h"
#include "core/frames/cloud.h"
#include "core/virtual/virtualizer.h"
#include "test/sim/world/geometry.h"
#include "test/sim/world/rng.h"
#include "test/support/merge_score.h"

namespace lidard::sim {

/// A world of solids on flat ground, exact for rays: the truth for clouds and for what is cut from them.
struct Yard {
  std::vector<Object> objects;  ///< without the ground
  bool ground = true;           ///< at z = 0
  /// m along the ray to the first thing; infinite if there is none.
  double cast(const Ray& ray, bool with_ground) const;
};

/// A multi-plane lidar that turns clockwise and fires all rings at once.
struct YardLidar {
  std::vector<double> elevations;  ///< rad, ascending
  std::size_t columns = 1800;
  double noise = 0;                  ///< one standard deviation, m
  double range_max = 100;            ///< m
  Pose pose = Pose::Identity();      ///< in the world
  std::vector<double> offsets{};     ///< rad clockwise by which rings point ahead; empty: none
  std::function<Pose(Span)> path{};  ///< where it is so long after the cloud's stamp; empty: at `pose`
};

/// `count` rings from `lowest` to `highest`, degrees.
std::vector<double> even_rings(std::size_t count, double lowest_deg, double highest_deg);
/// What the lidar measures; its columns are known, as drivers make clouds.
Cloud measure(const Yard& yard, const YardLidar& lidar, Rng& rng);

/// A lidar and a virtual frame over a random yard: what methods are compared in.
struct YardCase {
  const char* name;
  std::vector<double> elevations;
  Pose virtual_pose;  ///< in the vehicle's frame
};
const std::vector<YardCase>& yard_cases();

/// 50 x 40 m with 14 blocks of 0.3 to 2.8 m and some slabs overhead, seen from 2 m above its middle.
struct YardScene {
  Yard yard;
  YardLidar lidar;
  Cloud cloud;
  ScanGrid grid;
  Pose virtual_pose;
  std::vector<double> truth;  ///< m per beam, of all but the ground
  std::vector<char>
      visible;  ///< nothing is between the lidar and any place of the way to what the beam meets
  /// Visible, and a beam of the lidar meets that thing on either side of the plane or beside it: what is
  /// lower than the next beam above the plane stands between two beams.
  std::vector<char> sampled;
};
YardScene make_yard_scene(const YardCase& set_up, std::uint64_t seed);

/// Counts over beams of which the lidar could see the whole way and the true hit.
struct YardScore {
  std::uint64_t beams = 0, visible = 0, sampled = 0, sampled_missed = 0, right = 0, phantom = 0, through = 0,
                free = 0, silent = 0;
  std::uint64_t hidden_wrong = 0;  ///< claims about the other beams that are wrong
  void add(const YardScore& other);
  double share(std::uint64_t count) const {
    return 100.0 * static_cast<double>(count) / static_cast<double>(visible);
  }
  double share_missed_of_sampled() const {
    return 100.0 * static_cast<double>(sampled_missed) / static_cast<double>(sampled);
  }
  double missed() const { return share(through + free + silent); }
};
YardScore judge_yard(const YardScene& scene, const std::vector<Claim>& claims);

/// The nearest point per beam of those within `half_height` of the plane: what other tools do.
std::vector<Claim> banded_claims(const YardScene& scene, double half_height);
/// Our own cut in one profile.
std::vector<Claim> cut_claims(const YardScene& scene, Profile profile,
                              GroundModel model = GroundModel::plane);

}  // namespace lidard::sim
