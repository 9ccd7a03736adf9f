// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/evidence/visibility.h"
#include "core/merge/merger.h"
#include "test/sim/world/flat_world.h"

namespace lidard::sim {

/// A set-up of two scanners on a vehicle, and what it is judged with.
struct MergeCase {
  const char* name;
  bool diagonal;      ///< scanners on opposite corners, output in the middle; else on both front corners
  double source_deg;  ///< between beams
  std::size_t beams;  ///< of the output
  double noise;       ///< one standard deviation, m
  bool veils;
  bool driving = false;  ///< sweeps of 60 ms while the vehicle swings; odometry of 50 Hz
};

/// The set-ups whose figures are compared.
const std::vector<MergeCase>& merge_cases();

/// What a merged scan says of one beam, of any method.
struct Claim {
  enum Kind : std::uint8_t { nothing, free, hit } kind = nothing;
  double range = 0;  ///< m
};

std::vector<Claim> claims_of_scan(const PlanarScan& scan);

/// Counts over the beams of many scenes. `seen` beams are those whose whole true path some scanner sees.
struct MergeScore {
  std::uint64_t seen = 0, right = 0, see_through = 0, phantom = 0, false_free = 0, silent = 0;
  std::uint64_t unseen = 0, unseen_free = 0, unseen_wrong = 0;
  std::vector<float> errors;  ///< m, of right hits
  void add(const MergeScore& other);
  double share(std::uint64_t count) const {
    return 100.0 * static_cast<double>(count) / static_cast<double>(seen);
  }
  double unseen_share(std::uint64_t count) const {
    return unseen == 0 ? 0 : 100.0 * static_cast<double>(count) / static_cast<double>(unseen);
  }
  double rms() const;
  double bias() const;
  double p99() const;
};

/// A random scene with its scanners, their sweeps and the truth per output beam, in the output's frame.
struct MergeScene {
  FlatWorld world;
  std::vector<FlatScanner> scanners;
  std::vector<PlanarScan> scans;
  std::vector<SweepMotion> motions;  ///< of the vehicle, during each sweep
  Footprint body;
  ScanGrid grid;
  std::vector<double> truth;     ///< m per beam; infinite: nothing
  std::vector<char> observable;  ///< per beam
};

/// Of the output, m. The scanners measure to 25 m; the way to 24 m is within reach of one of them everywhere.
constexpr double merge_range_max = 24;

/// Two scanners, an oblong vehicle and twelve boxes in a room of 30 x 20 m.
MergeScene make_scene(const MergeCase& set_up, std::uint64_t seed);
/// Judges one method's claims.
MergeScore judge(const MergeScene& scene, const MergeCase& set_up, const std::vector<Claim>& claims);

/// What ira_laser_tools' formula gives: floor of the angle, nearest point, range_max + 1 for nothing.
std::vector<Claim> ancestor_claims(const MergeScene& scene);
/// The nearest point per beam with the angle rounded to the nearest beam.
std::vector<Claim> rounding_claims(const MergeScene& scene);

/// Our own merge of a scene in both profiles.
struct TruthfulClaims {
  std::vector<Claim> strict, safety;
  std::uint64_t dropped = 0;  ///< returns of scanners that the safety scan has nothing at or before
  std::uint64_t returns = 0;
};
TruthfulClaims truthful_claims(const MergeScene& scene, const MergeCase& set_up);

}  // namespace lidard::sim
