// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/frames/cloud.h"
#include "core/merge/merger.h"
#include "core/motion/frame_motion.h"

namespace lidard {

/// Merges the newest clouds of several sources into one, every return brought to one instant. A sweep of a
/// planar scanner is a cloud of one ring. When, and which sources are fit to be used, is for the Scheduler to
/// say. Memory is kept from cloud to cloud.
class CloudMerger {
 public:
  /// `organised`: rows instead of a list, those of the first source's rings first, the lowest ring of each
  /// first, with a column per firing sequence (of a planar scanner: per beam and echo); what is missing there
  /// is NaN. A cloud without firing sequences (of another driver) makes all of it a list.
  CloudMerger(std::size_t sources, bool organised);

  /// Keeps a copy, without points unless `with_points`; `vehicle_from_cloud` is the pose of its lidar. False
  /// for what is not newer than the source's last one: it is counted and not used. A stamp more than 1 s back
  /// is an input that starts again: all clouds are forgotten.
  bool add(std::size_t source, const Cloud& cloud, const Pose& vehicle_from_cloud, bool with_points = true);
  bool add(std::size_t source, const PlanarScan& scan, const Pose& vehicle_from_scan,
           bool with_points = true);
  /// Brings the clouds of the sources that `use` names (one flag per source) to `moment` and writes their
  /// returns to `merged` in moment's output frame. The caller sets the frame's name. The report stays valid
  /// until the next call.
  const MergeReport& merge(const MergeMoment& moment, const std::vector<char>& use, MergedCloud& merged);
  /// The clouds of the last merge, by source; those not used are nullptr. Valid until the next add().
  const std::vector<PlacedCloud>& placed() const { return placed_; }
  /// Forgets all clouds (the input starts again).
  void reset();

  std::uint64_t superseded() const { return superseded_; }      ///< clouds replaced by a newer one before use
  std::uint64_t out_of_order() const { return out_of_order_; }  ///< clouds older than one of the same source

 private:
  struct Source {
    Cloud cloud;
    Pose vehicle_from_cloud = Pose::Identity();
    CloudMotion motion;
    std::optional<Stamp> stamp;
    bool fresh = false;
    bool is_sweep = false;
  };
  bool accept(std::size_t source, Stamp stamp, const Pose& vehicle_from_cloud);
  SourceUse bring(Source& source, const MergeMoment& moment) const;
  bool can_be_organised() const;
  void set_slots(MergedCloud& merged);
  void write(std::size_t source, const Pose& output_from_base, MergedCloud& merged) const;

  const bool organised_;
  std::vector<Source> sources_;
  std::vector<PlacedCloud> placed_;
  std::vector<std::size_t> first_slots_;  // of each source, in the cloud that is written
  std::size_t width_ = 0;                 // columns of an organised cloud; 0: it is a list
  MergeReport report_;
  std::uint64_t superseded_ = 0, out_of_order_ = 0;
};

}  // namespace lidard
