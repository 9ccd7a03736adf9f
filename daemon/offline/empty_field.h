// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/files/snapshot_view.h"
#include "daemon/offline/no_transforms.h"

namespace lidard {

/// Which limits of the sensors hold: all, one alone, or none. `heights`: the heights that count, and tilted
/// scanners that meet the ground. Without `elevations` lidars and virtual scans are level at one height, so
/// that no zone is blind. The vehicle's outline always holds.
enum class Limit : std::uint8_t { all, angles, elevations, heights, reach, none };

/// Stands for a sensor whose field of view is not known.
const Model& usual_model(FrameKind kind);

/// The frames of a configuration's sensors on level ground (z = 0 of base_frame) with nothing on it, and the
/// merged and virtual scans that the pipeline makes of them.
///
///     roof o---------------- no return        A planar scanner meets nothing unless it looks down.
///          |`-.___                            A ring of a lidar meets the ground, or nothing. Before that
///   front o|------`-.___--- no return         each ring has met something, so that its direction is known.
///     _____|____________`-.____ ground        Beams are those of the model, between the configured angles.
///
/// The vehicle stands. All outputs have the profile strict. A sensor whose field of view is not known has
/// that of a TiM7xx (270 degrees), or of a VLP-16.
class EmptyField {
 public:
  explicit EmptyField(const Config& config, Limit holds = Limit::all);
  EmptyField(const EmptyField&) = delete;
  EmptyField& operator=(const EmptyField&) = delete;

  /// The configuration that was played: each sensor has a model.
  const Config& config() const { return config_; }
  const FrameKeeper& frames() const { return frames_; }
  /// Poses of the configuration alone.
  const FrameTree& poses() const { return poses_; }
  /// Names of the sensors whose field of view is assumed.
  const std::vector<std::string>& assumed() const { return assumed_; }
  /// m along the plane from a lidar to where its first ring meets the plane, which is nearer than that in its
  /// blind zone; 0: no ring meets it.
  double blind_range(const SensorConfig& lidar, const Pose& plane_from_lidar) const;

 private:
  void play(Limit holds);
  Pose pose_of(const SensorConfig& sensor, Limit holds) const;

  Config config_;
  NoTransforms no_tf_;
  FrameTree poses_;
  std::map<std::string, FieldOfView> views_;  // of the sensors
  std::vector<std::string> assumed_;
  FrameKeeper frames_;
};

}  // namespace lidard
