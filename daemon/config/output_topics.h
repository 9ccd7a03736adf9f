// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"

namespace lidard {

/// What travels on a topic. A scan with several echoes goes to a topic of its own (MultiEchoLaserScan).
enum class TopicKind : std::uint8_t { scan, echoes, cloud, fix, time_reference, imu, state };

/// One output topic; `name` as ROS has it (relative names are resolved by the sink).
struct TopicInfo {
  std::string name;
  TopicKind kind;
};

/// A topic that something in a configuration may publish on.
struct OutputTopic {
  TopicInfo info;
  bool promised;  ///< comes with every frame; else only when the device has something to tell
};

/// The topic of a sensor's own frames: its cloud, or its scan.
TopicInfo frame_topic(const SensorConfig& sensor);
/// True if what the device tells beside its frames (inputs, outputs, fields) is published.
bool publishes_states(const SensorConfig& sensor);
/// Everything that a sensor of ours may publish on; a source with `topic:` publishes nothing.
std::vector<OutputTopic> sensor_topics(const SensorConfig& sensor);
/// Everything that the configuration may publish on.
std::vector<OutputTopic> output_topics(const Config& config);
/// Every topic that a pipeline of this configuration may publish on.
std::vector<TopicInfo> pipeline_topics(const Config& config);

}  // namespace lidard
