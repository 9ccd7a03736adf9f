// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "core/base/time.h"
#include "core/motion/pose_track.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

/// Watches that the vehicle's poses keep up with the sensors' data. Stamps are compared with stamps alone,
/// since under simulated time, or in a replay, they are of another clock than arrivals.
class MotionWatch {
 public:
  /// Data of a sensor came in that was measured at `stamp`.
  void data(Stamp stamp, Stamp now);
  /// The track may have new poses.
  void poses(const PoseTrack& track, Stamp now);
  /// What is wrong and what to look for; empty: nothing.
  std::string trouble(const PoseTrack& track, Stamp now) const;
  /// The same for /diagnostics. `refused`: poses that were not used, the last one because of `why`.
  DiagnosticItem diagnostics(const PoseTrack& track, std::uint64_t refused, const std::string& why,
                             Stamp now) const;
  /// s that the newest data are ahead of the newest pose; none: one of them is missing.
  std::optional<double> lag(const PoseTrack& track) const;

 private:
  struct Newest {
    Stamp stamp;
    Stamp arrival;
  };
  std::optional<Newest> data_;
  std::optional<Newest> pose_;
};

}  // namespace lidard
