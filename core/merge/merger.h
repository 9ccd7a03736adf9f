// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/evidence/flatten.h"
#include "core/evidence/visibility.h"
#include "core/frames/cloud.h"

namespace lidard {

/// One output of a merge.
struct MergedScan {
  Profile profile;
  PlanarScan* scan;
};

/// What a merge computes.
struct MergeSettings {
  bool points = true;       ///< keeps the points, for profile `flatten` and the cloud
  bool visibility = false;  ///< surfaces and free space, for profiles `strict` and `safety`
  VisibilitySettings how;
  SourceSettings source;               ///< of every source
  std::vector<SourceSettings> each{};  ///< per source; empty: `source` for all
};

/// How a merge used a source. `static_poses`: its points are not deskewed, since poses are missing (or there
/// is no track). `extrapolated`: deskewed, partly beyond the newest pose.
enum class SourceUse : std::uint8_t { not_used, static_poses, deskewed, extrapolated };

/// The result of a merge.
struct MergeReport {
  std::vector<SourceUse> sources;
  bool deskewed = false;  ///< at least one source was deskewed
};

/// Merges the newest sweeps of several single-plane scanners into one scan, all beams deskewed to one
/// instant. The Scheduler decides when to merge and which sources to use.
class Merger {
 public:
  Merger(const ScanGrid& grid, HeightBand band, std::size_t sources, const MergeSettings& settings = {});

  /// Sets the vehicle's outline in the output frame: returns inside hit the vehicle itself.
  void set_footprint(const Footprint& footprint);

  /// Stores a sweep; `output_from_sensor` transforms the scanner's coordinates to the output frame. Returns
  /// false and counts the sweep if it is not newer than the source's last one or if its beams have impossible
  /// times. A stamp more than 1 s back means that the input starts again: all sweeps are dropped.
  bool add(std::size_t source, const PlanarScan& scan, const Pose& output_from_sensor);
  /// Merges the sweeps of the sources selected by `use` (one flag per source), deskewed to `moment`, whose
  /// instant is the stamp. The caller sets the frame names. All points go to `cloud` (ring = source, time 0)
  /// unless it is nullptr. The report stays valid until the next call.
  const MergeReport& merge(const MergeMoment& moment, const std::vector<char>& use,
                           const std::vector<MergedScan>& outputs, Cloud* cloud);
  /// Drops all sweeps (the input starts again).
  void reset();

  /// Number of sweeps that a newer one of the same source replaced before they were used.
  std::uint64_t superseded() const { return superseded_; }
  /// Number of sweeps rejected because a newer one of the same source had been accepted.
  std::uint64_t out_of_order() const { return out_of_order_; }
  /// Number of sweeps rejected because the time between beams was not finite, negative or too long.
  std::uint64_t bad_times() const { return bad_times_; }
  /// Times of the beams of a source's newest sweep; nullopt if it has none.
  std::optional<SweepTimes> times(std::size_t source) const;
  /// The state of every beam; nullptr if no profile needs it.
  const Visibility* visibility() const { return visibility_ ? &*visibility_ : nullptr; }
  /// A source's sweep in the output frame of the last merge; nullptr if it was not used or no surfaces are
  /// computed.
  const PlacedScan* sweep(std::size_t source) const { return newest_sweeps_[source]; }
  /// A source's newest sweep, whether the last merge used it or not; for its counters.
  const PlacedScan& last_sweep(std::size_t source) const { return sources_[source].sweep; }
  /// The origin of a source's sweep, in the output frame.
  Eigen::Vector2d looks_from(std::size_t source) const {
    return sources_[source].rays.pose.translation().head<2>();
  }

 private:
  struct Point {
    Eigen::Vector3d position;  // as measured
    float intensity;
    std::uint32_t beam;
  };
  struct Source {
    std::vector<Point> points;
    std::optional<Stamp> stamp;
    SweepTimes times;
    SweepMotion motion;
    bool fresh = false;
    bool has_intensities = false;
    float scan_time = 0;
    BeamRays rays;
    bool rays_outdated = true;  // the vehicle's outline has changed
    PlacedScan sweep;
  };
  const SourceSettings& settings_of(std::size_t source) const {
    return settings_.each.empty() ? settings_.source : settings_.each[source];
  }
  bool with_intensities(const std::vector<char>& use) const;
  static void transform_points(const PlanarScan& scan, const SourceSettings& settings, Source& source);
  void flatten(PlanarScan& scan, bool intensities);
  void fill(Cloud& cloud) const;
  SourceUse transform_source(std::size_t index, const MergeMoment& moment);
  bool used(std::size_t source) const { return report_.sources[source] != SourceUse::not_used; }
  template <class Use>
  static void each_point(const Source& source, Use use);

  MergeSettings settings_;
  HeightBand band_;
  Footprint footprint_;
  Flattener flattener_;
  std::optional<Visibility> visibility_;
  std::vector<const PlacedScan*> newest_sweeps_;
  std::vector<Source> sources_;
  std::uint64_t superseded_ = 0;
  std::uint64_t out_of_order_ = 0;
  std::uint64_t bad_times_ = 0;
  MergeReport report_;
};

}  // namespace lidard
