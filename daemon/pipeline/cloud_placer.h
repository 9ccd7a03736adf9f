// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "core/frames/cloud_layout.h"
#include "core/motion/frame_motion.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/pose_gate.h"
#include "daemon/pipeline/vehicle_motion.h"

namespace lidard {

/// Brings the clouds of a sensor to the frame and the instant in which they are published
/// (SensorConfig::points_frame, deskew). The instant is the stamp of the message. A cloud whose poses are not
/// known yet waits for them 0.2 s, as it does in velodyne_pointcloud (datacontainerbase.h, 1.7.0), but no
/// more than four clouds wait. Memory is kept from cloud to cloud.
class CloudPlacer {
 public:
  using Publish = std::function<void(Cloud& cloud, Stamp now)>;

  /// All must outlive this. `publish` may swap out the bytes of the points.
  CloudPlacer(const SensorConfig& sensor, const CloudArranger& arranger, VehicleMotion& motion,
              Publish publish);
  static bool is_wanted(const SensorConfig& sensor) { return sensor.deskew || !sensor.points_frame.empty(); }

  void add(const Cloud& cloud, Stamp now);
  /// Time passed, or poses came in: publishes what has waited long enough.
  void advance(Stamp now);
  /// When advance() is worth a call.
  std::optional<Stamp> next_event() const;
  /// No poses will come any more: publishes what can be published.
  void finish(Stamp now);
  const PoseGate& gate() const { return gate_; }

 private:
  struct Waiting {
    Cloud cloud;
    Stamp instant;  // the stamp of the message
    Stamp since;
  };
  /// Publishes the first ones whose poses are known, or that have waited long enough.
  void release_due(Stamp now);
  /// False: its poses are not known, and it may still wait for them.
  bool release(Waiting& waiting, bool may_wait, Stamp now);
  bool find_motion(const Cloud& cloud, Stamp instant);
  void release_first(Stamp now);
  void drop_first();

  const SensorConfig& sensor_;
  const CloudArranger& arranger_;
  VehicleMotion& vehicle_;
  Publish publish_;
  PoseGate gate_;
  std::vector<Waiting> clouds_;  // the first `waiting_` ones, oldest first
  std::size_t waiting_ = 0;
  Stamp last_try_{};
  CloudMotion motion_;
  CloudMotion stands_;
};

}  // namespace lidard
