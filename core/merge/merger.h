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

/// What a merge computes beside points.
struct MergeSettings {
  bool points = true;       ///< keeps the points, for profile `flatten` and the cloud
  bool visibility = false;  ///< surfaces and free space, for profiles `strict` and `safety`
  VisibilitySettings how;
  SourceSettings source;               ///< of every source
  std::vector<SourceSettings> each{};  ///< per source, where they differ; empty: `source` for all
};

/// What became of a source in a merge. `static_poses`: its points stand where they were measured, since poses
/// are missing (or there is no track at all). `extrapolated`: deskewed, partly beyond the newest pose.
enum class SourceUse : std::uint8_t { not_used, static_poses, deskewed, extrapolated };

/// What a merge did.
struct MergeReport {
  std::vector<SourceUse> sources;
  bool deskewed = false;  ///< of some source
};

/// Merges the newest sweeps of several single-plane scanners into one scan, all beams brought to one instant.
/// When, and which sources are fit to be used, is for the Scheduler to say.
class Merger {
 public:
  Merger(const ScanGrid& grid, HeightBand band, std::size_t sources, const MergeSettings& settings = {});

  /// The vehicle's outline in the output frame: what lies inside is the vehicle's own.
  void set_footprint(const Footprint& footprint);

  /// Stores a sweep; `output_from_sensor` takes the scanner's coordinates to the output frame. False for
  /// sweeps that are not newer than the source's last one, or whose beams have impossible times: they are
  /// counted and not used. A stamp more than 1 s back is an input that starts again: all sweeps are
  /// forgotten.
  bool add(std::size_t source, const PlanarScan& scan, const Pose& output_from_sensor);
  /// Merges the sweeps of the sources that `use` names (one flag per source), brought to `moment`, whose
  /// instant is the stamp. The caller sets the frames' names. If `cloud` is not nullptr it gets all points
  /// (ring = source, time 0). The report stays valid until the next call.
  const MergeReport& merge(const MergeMoment& moment, const std::vector<char>& use,
                           const std::vector<MergedScan>& outputs, Cloud* cloud);
  /// Forgets all sweeps (the input starts again).
  void reset();

  /// Sweeps that were replaced by a newer one of the same source before they were used.
  std::uint64_t superseded() const { return superseded_; }
  /// Sweeps older than one of the same source already taken; not used.
  std::uint64_t out_of_order() const { return out_of_order_; }
  /// Sweeps with a time between beams that is not finite, negative or too long.
  std::uint64_t bad_times() const { return bad_times_; }
  /// When the beams of a source's newest sweep were measured; none if it has none.
  std::optional<SweepTimes> times(std::size_t source) const;
  /// What is known of each beam; nullptr if no profile needs it.
  const Visibility* visibility() const { return visibility_ ? &*visibility_ : nullptr; }
  /// A source's sweep as the last merge placed it; nullptr: it was not used, or no surfaces are computed.
  const PlacedScan* sweep(std::size_t source) const { return newest_sweeps_[source]; }
  /// Where it was measured from, in the output frame.
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
  static void place_points(const PlanarScan& scan, const SourceSettings& settings, Source& source);
  void flatten(PlanarScan& scan, bool intensities);
  void fill(Cloud& cloud) const;
  SourceUse bring(std::size_t index, const MergeMoment& moment);
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
