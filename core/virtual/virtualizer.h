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

/// Makes virtual single-plane scans from multi-plane clouds, as scanners in the virtual frames would have
/// them.
class Virtualizer {
 public:
  /// `frames` virtual frames share a grid of beams, a height band and the work that is done once per cloud.
  Virtualizer(const ScanGrid& grid, HeightBand band, std::size_t frames = 1,
              const VirtualSettings& settings = {});

  /// The vehicle's outline (in its own frame, without margin); returns inside it and near it are left out.
  void set_footprint(const Footprint& footprint);
  /// The cloud of the following scans; it must stay alive, and so must `motion`, which moves its returns to
  /// the instant that the scans shall show.
  void set_cloud(const Cloud& cloud, const Pose& vehicle_from_cloud, const CloudMotion* motion = nullptr);
  /// Makes the scans of one frame; `virtual_from_cloud` takes the cloud's coordinates to it. Stamp and frame
  /// period come from the cloud; the caller sets the frame's name.
  void project(std::size_t frame, const Pose& virtual_from_cloud, const std::vector<VirtualScan>& outputs);

  /// Why nothing is known of surfaces and free space of the newest cloud; empty: it is.
  const char* why_no_surfaces() const { return organised_ ? "" : grid_.why_not(); }
  std::uint64_t own_returns() const { return grid_.own_returns; }
  /// What is known of a frame's beams; only with `visibility`.
  const Visibility& visibility(std::size_t frame) const { return frames_[frame]->visibility; }

 private:
  struct Frame {
    Frame(const ScanGrid& grid, const VisibilitySettings& how);
    Visibility visibility;
    Pose pose = Pose::Identity();  // virtual_from_cloud that the tables were made for
    double step = 0;               // rad between columns, likewise
    bool placed = false;
  };
  void place_cloud(const Pose& vehicle_from_cloud);
  template <class Use>
  void each_return(const Pose& virtual_from_cloud, Use use) const;
  void flatten(const Pose& virtual_from_cloud, PlanarScan& scan);
  void look(Frame& frame, const Pose& virtual_from_cloud);
  void cut_slice(Visibility& visibility, double level);
  void cut_band(Visibility& visibility, float evidence_level);
  void place(Frame& frame, const Pose& virtual_from_cloud) const;
  void splat_points(Frame& frame, const Pose& virtual_from_cloud);
  float evidence_level(const Pose& virtual_from_cloud) const;

  VirtualSettings settings_;
  HeightBand band_;
  Flattener flattener_;
  Footprint footprint_;
  Footprint own_;  // with its margin
  bool placed_ = false;
  const Cloud* cloud_ = nullptr;
  const CloudMotion* motion_ = nullptr;  // nullptr: everything stands
  Pose vehicle_from_cloud_ = Pose::Identity();
  bool organised_ = false;
  RingGrid grid_;
  Ground ground_;
  RingLinks neighbours_;
  PlaneView view_;
  PlaneTops tops_;
  PlaneCut cut_;
  CutEvidence evidence_;
  std::vector<std::unique_ptr<Frame>> frames_;
};

}  // namespace lidard
