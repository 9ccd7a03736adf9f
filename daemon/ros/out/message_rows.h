// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>

#include "core/base/host_clock.h"
#include "daemon/pipeline/sink.h"
#include "daemon/ros/messages/raw_message.h"

namespace lidard {

/// Makes messages of one type. Keeps the memory of the message for the next one.
class MessageMaker {
 public:
  virtual ~MessageMaker() = default;
  virtual const MessageType& type() const = 0;
  /// `frame` must be of the topic's type. The message holds the points of a cloud where they are, and the
  /// cloud gets other memory.
  virtual RawMessage make(const Frame& frame, Stamp released, const ClockStep& clock) = 0;
};

/// Publication of a kind of topic.
struct MessageRow {
  TopicKind kind;
  std::size_t message;  ///< of TopicKind::message: message_kind() of the frame
  /// Frames that may wait for publication. A stalled thread publishes late: the planar scans of a second (no
  /// scanner turns faster than 100 Hz), and the inertial samples of a quarter of one. Clouds are large and
  /// soon outdated.
  std::size_t queue_depth;
  std::unique_ptr<MessageMaker> (*maker)();
};
const MessageRow& row_of(const OutputTopic& topic);

/// For fixed transforms, and for the time of a replay.
std::unique_ptr<MessageMaker> transforms_maker();
std::unique_ptr<MessageMaker> clock_maker();

/// Where the outline of the vehicle is published, if it has one.
constexpr const char* outline_topic = "footprint";
/// The outline of the vehicle, at any time (geometry_msgs/PolygonStamped).
RawMessage outline_of(const VehicleConfig& vehicle);

}  // namespace lidard
