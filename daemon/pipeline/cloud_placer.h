// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/frames/cloud_layout.h"
#include "core/motion/frame_motion.h"
#include "core/motion/pose_gate.h"
#include "daemon/config/config.h"
#include "daemon/pipeline/context.h"

namespace lidard {

/// Transforms the clouds of a sensor to the frame and the instant of publication (SensorConfig::points_frame,
/// deskew). The instant is the stamp of the message. A cloud waits up to 0.2 s for its poses, as in
/// velodyne_pointcloud (datacontainerbase.h, 1.7.0), and at most four clouds wait. Buffers keep their memory.
class CloudPlacer {
 public:
  /// The arguments must outlive this; `topic`: of the clouds.
  CloudPlacer(const SensorConfig& sensor, CloudArranger& arranger, const PipelineContext& context,
              Route& topic)
      : sensor_(sensor), arranger_(arranger), context_(context), topic_(topic) {}
  static bool is_wanted(const SensorConfig& sensor) { return sensor.deskew || !sensor.points_frame.empty(); }

  void add(const Cloud& cloud, Stamp now);
  /// Call after time or poses have advanced: publishes clouds that are ready.
  void advance(Stamp now);
  /// The next time to call advance().
  std::optional<Stamp> next_event() const;
  /// End of the poses: publishes the waiting clouds as far as possible.
  void finish(Stamp now);
  const PoseGate& gate() const { return gate_; }

 private:
  struct Waiting {
    Cloud cloud;
    Stamp instant;  // the stamp of the message
    Stamp since;
  };
  /// Publishes the oldest clouds whose poses are known or whose wait is over.
  void release_due(Stamp now);
  /// False if the cloud must wait for its poses.
  bool release(Waiting& waiting, bool may_wait, Stamp now);
  bool find_motion(const Cloud& cloud, Stamp instant);
  void release_first(Stamp now);
  void drop_first();

  const SensorConfig& sensor_;
  CloudArranger& arranger_;
  const PipelineContext& context_;
  Route& topic_;
  PoseGate gate_;
  std::vector<Waiting> clouds_;  // the first `waiting_` ones, oldest first
  std::size_t waiting_ = 0;
  Stamp last_try_{};
  CloudMotion motion_;
  CloudMotion stands_;
};

}  // namespace lidard
