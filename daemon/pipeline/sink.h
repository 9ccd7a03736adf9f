// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <variant>
#include <vector>

#include "core/base/pose.h"
#include "core/frames/cloud.h"
#include "core/frames/device_message.h"
#include "core/frames/scan.h"
#include "daemon/config/config.h"

namespace lidard {

/// What travels on a topic. Refers to what the caller holds.
struct Payload : std::variant<const PlanarScan*, Cloud*, MergedCloud*, const DeviceMessage*,
                              const std::vector<StaticTransform>*, const Stamp*> {
  Payload(const PlanarScan& scan) : variant(&scan) {}
  /// The receiver of a cloud may swap out its points_bytes.
  Payload(Cloud& cloud) : variant(&cloud) {}
  Payload(MergedCloud& cloud) : variant(&cloud) {}
  Payload(const DeviceMessage& message) : variant(&message) {}
  Payload(const std::vector<StaticTransform>& transforms) : variant(&transforms) {}
  /// The time of a replay.
  Payload(const Stamp& now) : variant(&now) {}
};

/// Gets what the pipeline finished: ROS, a bag, a file, a test. Called from the sensor thread; must not
/// block. The topics are entries of output_topics() of the pipeline's configuration.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  /// False while the topic has no consumer, so that its frames need not be made.
  virtual bool wants(const OutputTopic& /*topic*/) const { return true; }
  /// Called in place of publish() for a frame that was not made, since no sink wants it.
  virtual void skip(const OutputTopic& /*topic*/, Stamp /*released*/) {}
  /// `released`: arrival of the packet that completed the frame.
  virtual void publish(const OutputTopic& topic, const Payload& payload, Stamp released) = 0;
  virtual void transforms(const std::vector<StaticTransform>& /*transforms*/, Stamp /*released*/) {}
};

}  // namespace lidard
