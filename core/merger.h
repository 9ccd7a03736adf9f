// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/cloud.h"
#include "core/flatten.h"
#include "core/sight.h"

namespace lidard {

/// One output of a merge.
struct MergedScan {
  Profile profile;
  PlanarScan* scan;
};

/// What a merge computes beside points.
struct MergeSettings {
  bool points = true;  ///< keeps the points, for profile `flatten` and the cloud
  bool sight = false;  ///< surfaces and free space, for profiles `strict` and `safety`
  SightSettings how;
  SourceSettings source;  ///< of every source
};

/// Merges the newest sweeps of several single-plane scanners into one scan.
///
/// An output is due when every source that is alive has delivered since the last one. A source that was
/// silent for `lost_after` (by the stamps of the others) is neither waited for nor used, so a dead scanner
/// cannot stop the output.
class Merger {
 public:
  Merger(const ScanGrid& grid, HeightBand band, std::size_t sources, Span lost_after,
         const MergeSettings& settings = {});

  /// The vehicle's outline in the output frame: what lies inside is the vehicle's own.
  void set_footprint(const Footprint& footprint);

  /// Stores a sweep; `output_from_sensor` takes the scanner's coordinates to the output frame.
  /// True when an output is due: call merge().
  bool add(std::size_t source, const PlanarScan& scan, const Pose& output_from_sensor);
  /// Merges what is there. Stamp: the newest of the sweeps' first rays, strictly increasing from output to
  /// output. The caller sets the frames' names. If `cloud` is not nullptr it gets all points (ring = source,
  /// time 0).
  void merge(const std::vector<MergedScan>& outputs, Cloud* cloud);
  /// The same for a single output of profile `flatten`.
  void merge(PlanarScan& scan, Cloud* cloud) { merge({{Profile::flatten, &scan}}, cloud); }
  /// Forgets all sweeps (the input starts again).
  void reset();

  /// Sweeps that were replaced by a newer one of the same source before they were used.
  std::uint64_t superseded() const { return superseded_; }
  /// Sweeps older than one of the same source already taken; not used.
  std::uint64_t out_of_order() const { return out_of_order_; }
  /// True if the source is alive at the newest stamp seen.
  bool alive(std::size_t source) const;

 private:
  struct Point {
    Eigen::Vector3d position;
    float intensity;
  };
  struct Source {
    std::vector<Point> points;
    std::optional<Stamp> stamp;
    bool fresh = false;
    bool has_intensities = false;
    float scan_time = 0;
    BeamRays rays;
    Sweep sweep;
  };
  bool is_due() const;
  bool intensities_everywhere() const;
  void take_points(const PlanarScan& scan, const Pose& output_from_sensor, Source& source) const;
  void take_sweep(std::size_t index, const PlanarScan& scan, const Pose& output_from_sensor);
  void flatten(PlanarScan& scan, bool intensities);
  void fill(Cloud& cloud) const;
  bool used(std::size_t source) const { return sources_[source].stamp && alive(source); }

  MergeSettings settings_;
  HeightBand band_;
  Footprint footprint_;
  Flattener flattener_;
  std::optional<Sight> sight_;
  std::vector<const Sweep*> newest_sweeps_;
  Span lost_after_;
  std::vector<Source> sources_;
  std::optional<Stamp> first_;
  Stamp newest_{};
  std::optional<Stamp> last_output_;
  std::uint64_t superseded_ = 0;
  std::uint64_t out_of_order_ = 0;
};

}  // namespace lidard
