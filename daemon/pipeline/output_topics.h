// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/pipeline/sink.h"

namespace lidard {

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

}  // namespace lidard
