// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>
#include <vector>

#include "core/base/host_clock.h"
#include "daemon/pipeline/sink.h"
#include "daemon/ros/messages/convert.h"
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

/// Makes a Message of a Content by to_ros(content, its stamp on the host's clock, message).
template <class Content, class Message>
class MakerOf final : public MessageMaker {
 public:
  const MessageType& type() const override { return type_of<Message>(); }
  RawMessage make(const Frame& frame, Stamp released, const ClockStep& clock) override {
    const Content& content = frame.of<Content>();
    if constexpr (std::is_same_v<Content, std::vector<StaticTransform>>)
      to_ros(content, clock.host(released), message_);
    else if constexpr (std::is_same_v<Content, Stamp>)
      message_.clock = to_ros(clock.host(content));
    else
      to_ros(content, clock.host(content.stamp), message_);
    return raw(message_);
  }

 private:
  Message message_;
};

template <class Content, class Message>
std::unique_ptr<MessageMaker> make_maker() {
  return std::make_unique<MakerOf<Content, Message>>();
}

/// The row of a topic that carries frames.
template <class Content, class Message>
MessageRow row(TopicKind kind, std::size_t queue_depth) {
  return {kind, 0, queue_depth, make_maker<Content, Message>};
}
/// The row of the topics of a device's messages of that kind.
template <class Content, class Message>
MessageRow row(std::size_t queue_depth) {
  return {TopicKind::message, message_kind<Content>(), queue_depth, make_maker<Content, Message>};
}

}  // namespace lidard
