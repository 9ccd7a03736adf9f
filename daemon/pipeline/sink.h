// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <type_traits>
#include <variant>
#include <vector>

#include "core/base/pose.h"
#include "core/frames/cloud.h"
#include "core/frames/device_message.h"
#include "core/frames/scan.h"
#include "core/motion/frame_motion.h"
#include "daemon/config/config.h"

namespace lidard {

/// What is delivered at once: a scan, a cloud, or another message of a topic. Refers to what the caller
/// holds.
struct Frame : std::variant<const PlanarScan*, Cloud*, MergedCloud*, const DeviceMessage*,
                            const std::vector<StaticTransform>*, const Stamp*> {
  Frame(const PlanarScan& scan) : variant(&scan) {}
  /// The receiver of a cloud may swap out its points_bytes. Without points: nobody wanted them, the cloud is
  /// only counted.
  Frame(Cloud& cloud, bool with_points = true) : variant(&cloud), has_points(with_points) {}
  /// `of`: the clouds that were merged, brought to its instant.
  Frame(MergedCloud& cloud, const std::vector<PlacedCloud>& of, bool with_points = true)
      : variant(&cloud), has_points(with_points), merged_of(&of) {}
  Frame(MergedCloud& cloud) : variant(&cloud) {}
  Frame(const DeviceMessage& message) : variant(&message) {}
  template <class Kind>
  Frame(const ReusedMessage<Kind>& message) : Frame(static_cast<const DeviceMessage&>(message)) {}
  Frame(const std::vector<StaticTransform>& transforms) : variant(&transforms) {}
  /// The time of a replay.
  Frame(const Stamp& now) : variant(&now) {}

  /// The content, which is of this type; else throws std::bad_variant_access.
  template <class Content>
  const Content& of() const {
    if constexpr (std::is_constructible_v<DeviceMessage, Content>)
      return std::get<Content>(*std::get<const DeviceMessage*>(*this));
    else
      return *std::get<const Content*>(*this);
  }
  /// nullptr, as below: it is something else.
  const PlanarScan* scan() const { return as<const PlanarScan>(); }
  Cloud* cloud() const { return as<Cloud>(); }
  MergedCloud* merged_cloud() const { return as<MergedCloud>(); }

  bool has_points = true;
  const std::vector<PlacedCloud>* merged_of = nullptr;

 private:
  template <class What>
  What* as() const {
    What* const* const found = std::get_if<What*>(this);
    return found == nullptr ? nullptr : *found;
  }
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
  virtual void publish(const OutputTopic& topic, const Frame& frame, Stamp released) = 0;
  virtual void transforms(const std::vector<StaticTransform>& /*transforms*/, Stamp /*released*/) {}
};

}  // namespace lidard
