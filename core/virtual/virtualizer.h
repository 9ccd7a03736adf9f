// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/evidence/flatten.h"
#include "core/evidence/visibility.h"
#include "core/frames/cloud.h"
#include "core/virtual/cut_evidence.h"
#include "core/virtual/plane_cut.h"

namespace lidard {

/// What of a cloud goes into a virtual scan with profile `strict` or `safety`. `slice`: where surfaces cross
/// the plane of the virtual frame. `band`: all surfaces between two heights, the nearest one per beam.
enum class CutMode : std::uint8_t { slice, band };

struct VirtualSettings {
  bool visibility = false;  ///< surfaces and free space, for profiles `strict` and `safety`
  CutMode mode = CutMode::slice;
  GroundSettings ground;
  VisibilitySettings how;
  RingGridSettings beams;
};

/// One output of a virtual frame.
struct VirtualScan {
  Profile profile;
  PlanarScan* scan;
};

/// Makes virtual single-plane scans from the clouds of one or several lidars, as scanners in the virtual
/// frames would have them. Each lidar's evidence of free space is its own: what one proves free, the blind
/// spot of another does not undo. The nearest surface of all counts.
class Virtualizer {
 public:
  /// `frames` virtual frames share a grid of beams, a height band and the work that is done once per cloud.
  /// There are so many `lidars`.
  Virtualizer(const ScanGrid& grid, HeightBand band, std::size_t frames = 1,
              const VirtualSettings& settings = {}, std::size_t lidars = 1);

  /// The vehicle's outline (in its own frame, without margin); returns inside it and near it are left out.
  void set_footprint(const Footprint& footprint);
  /// The clouds of the following scans, one for each lidar; they must stay alive, and so must their motions,
  /// which move returns to the instant that the scans shall show. Of a planar scanner's sweep only points are
  /// known.
  void set_clouds(const std::vector<PlacedCloud>& clouds);
  void set_cloud(const Cloud& cloud, const Pose& vehicle_from_cloud, const CloudMotion* motion = nullptr) {
    set_cloud(0, {&cloud, vehicle_from_cloud, motion, false});
  }
  /// Makes the scans of one frame; `virtual_from_cloud` takes each lidar's cloud to it. Stamp and frame
  /// period come from the first cloud; the caller sets the frame's name.
  void project(std::size_t frame, const Pose* virtual_from_cloud, const std::vector<VirtualScan>& outputs);
  void project(std::size_t frame, const Pose& virtual_from_cloud, const std::vector<VirtualScan>& outputs) {
    project(frame, &virtual_from_cloud, outputs);
  }

  /// Why surfaces and free space of a cloud are not known; empty: they are known of all clouds.
  const char* why_no_surfaces() const;
  std::uint64_t own_returns() const;
  /// What is known of a frame's beams; only with `visibility`.
  const Visibility& visibility(std::size_t frame) const { return frames_[frame]->visibility; }

 private:
  struct Frame {
    Visibility visibility;
    Pose virtual_from_vehicle = Pose::Identity();
    bool has_footprint = false;  // at that pose
  };
  struct Lidar {
    explicit Lidar(const RingGridSettings& beams) : grid(beams) {}
    PlacedCloud placed;
    bool has_pose = false;
    bool organised = false;
    RingGrid grid;
    Ground ground;
    RingLinks links;
    PlaneView view;
  };
  void set_cloud(std::size_t lidar, const PlacedCloud& cloud);
  void set_pose(std::size_t lidar, const Pose& vehicle_from_cloud);
  template <class Use>
  void each_return(const PlacedCloud& placed, const Pose& virtual_from_cloud, Use use) const;
  void flatten(const Pose* virtual_from_cloud, PlanarScan& scan);
  void look(Frame& frame, const Pose* virtual_from_cloud);
  void look(Frame& frame, std::size_t lidar, const Pose& virtual_from_cloud);
  void cut_slice(Lidar& lidar, Visibility& visibility, double level);
  void cut_band(Lidar& lidar, Visibility& visibility, float evidence_level);
  void transform_footprint(Frame& frame, const Pose& virtual_from_vehicle) const;
  void splat_points(const Lidar& lidar, Visibility& visibility, const Pose& virtual_from_cloud) const;
  float evidence_level(const Lidar& lidar, const Pose& virtual_from_cloud) const;

  VirtualSettings settings_;
  HeightBand band_;
  Flattener flattener_;
  Footprint footprint_;
  Footprint own_;  // with its margin
  std::vector<std::unique_ptr<Lidar>> lidars_;
  PlaneTops tops_;
  PlaneCut cut_;
  CutEvidence evidence_;
  std::vector<std::unique_ptr<Frame>> frames_;
};

}  // namespace lidard
