// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>

#include "core/evidence/beam_rays.h"
#include "core/evidence/placed_scan.h"
#include "core/evidence/visibility.h"
#include "test/support/merge_score.h"

namespace lidard::sim {

struct SlowRuleSettings {
  double edge = 0.004;  ///< m; nearer to an edge than this, rounding may decide
};

/// What may be said of a beam in profile strict.
struct SlowAnswer {
  Claim claim;
  bool sure = false;     ///< neither rounding decides nor what the rule leaves open
  double slack = 0;      ///< m, of a hit's range
  double walked_to = 0;  ///< m along the beam, to its end or where too much is unseen
};

/// The rule of free space, applied to every place along a beam. A place is seen to be free if it lies between
/// two neighbouring beams a and b of one source:
///
///     a1 ---- b1     from where the beams began to where their free ways end. Linked surely: to the straight
///       \     |      line. Else the nearer beam's distance counts as far as the border, beyond which an
///       object
///        a0 - b0     that it meets is missed, and from there the farther beam's.
///
/// Between the same two beams, behind the end of the way, a return hides the place. Every place asks all
/// pairs; nothing but the sweeps is shared with what the answers are compared with.
class SlowRule {
 public:
  /// `outline`: the vehicle in the output frame, and where it was when the oldest beam was measured.
  SlowRule(const ScanGrid& grid, const VisibilitySettings& how, const SlowRuleSettings& settings,
           const Footprint& outline, const std::optional<Pose>& former_from_now);
  void add(const PlacedScan& sweep, const BeamRays& rays);
  SlowAnswer answer(std::size_t beam);

 private:
  struct Scene;
  std::shared_ptr<Scene> scene_;
};

}  // namespace lidard::sim
