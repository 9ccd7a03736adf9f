// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"

namespace lidard {

/// What travels on a topic. A scan with several echoes goes to a topic of its own (MultiEchoLaserScan).
enum class TopicKind : std::uint8_t { scan, echoes, cloud, message };

/// A topic that something in a configuration may publish on.
struct OutputTopic {
  std::string name;  ///< as ROS has it (relative names are resolved by the sink)
  TopicKind kind;
  bool promised = true;     ///< comes with every frame; else only when the device has something to tell
  std::size_t message = 0;  ///< of TopicKind::message: message_kind() of what travels
  std::size_t id = 0;       ///< place in output_topics()
};

/// The topic of a sensor's own frames: its cloud, or its scan.
OutputTopic frame_topic(const SensorConfig& sensor);
/// Everything that a sensor of ours may publish on; a source with `topic:` publishes nothing.
std::vector<OutputTopic> sensor_topics(const SensorConfig& sensor);
/// The entry of that name, which must be there.
const OutputTopic& topic_named(const std::vector<OutputTopic>& topics, const std::string& name);
/// Everything that the configuration may publish on. At run time a topic travels as its entry of this list.
std::vector<OutputTopic> output_topics(const Config& config);

}  // namespace lidard
