// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <rosgraph_msgs/Clock.h>

#include <boost/mp11/algorithm.hpp>
#include <type_traits>
#include <utility>
#include <variant>

#include "daemon/config/output_topics.h"
#include "daemon/ros/ros_convert.h"
#include "daemon/ros/ros_device_message.h"

namespace lidard {

template <class List>
struct RosMessageOf;
template <class... Told>
struct RosMessageOf<std::variant<Told...>> {
  template <class One>
  using RosType = decltype(ros_type(std::declval<const One&>()));
  using Type = boost::mp11::mp_unique<
      std::variant<sensor_msgs::LaserScan, sensor_msgs::MultiEchoLaserScan, sensor_msgs::PointCloud2,
                   tf2_msgs::TFMessage, rosgraph_msgs::Clock, RosType<Told>...>>;
  static Type empty(std::size_t kind) {
    static const Type all[] = {RosType<Told>()...};
    return all[kind];
  }
};
/// A message of any type that goes out: of topics of frames, of device messages, on /tf_static and on /clock.
using RosMessage = RosMessageOf<DeviceMessage>::Type;

/// An empty message of the type that travels on a topic.
inline RosMessage message_for(const OutputTopic& topic) {
  switch (topic.kind) {
    case TopicKind::scan:
      return sensor_msgs::LaserScan();
    case TopicKind::echoes:
      return sensor_msgs::MultiEchoLaserScan();
    case TopicKind::cloud:
      return sensor_msgs::PointCloud2();
    case TopicKind::message:
      return RosMessageOf<DeviceMessage>::empty(topic.message);
  }
  return {};
}

inline void to_ros(Stamp now, rosgraph_msgs::Clock& message) { message.clock = to_ros(now); }

/// Fills `message` with to_ros(); false if a frame of this kind does not become a message of the type that
/// `message` holds.
template <class Frame>
bool convert(Frame& frame, RosMessage& message) {
  if constexpr (std::is_same_v<std::remove_const_t<Frame>, DeviceMessage>) {
    return std::visit([&message](const auto& told) { return convert(told, message); }, frame);
  } else {
    const auto to_held_type = [&frame](auto& held) -> decltype(to_ros(frame, held)) { to_ros(frame, held); };
    return std::visit(
        [&](auto& held) {
          constexpr bool fits = std::is_invocable_v<decltype(to_held_type), decltype(held)>;
          if constexpr (fits) to_held_type(held);
          return fits;
        },
        message);
  }
}

}  // namespace lidard
