// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/output_topics.h"

#include <stdexcept>
#include <utility>

namespace lidard {
namespace {

void add_merged(const MergedScanConfig& merged, std::vector<OutputTopic>& topics) {
  topics.push_back({merged.scan_destination_topic, TopicKind::scan});
  if (!merged.status_topic.empty()) topics.push_back({merged.status_topic, TopicKind::scan});
  for (const auto& also : merged.also) topics.push_back({also.topic, TopicKind::scan});
  if (!merged.cloud_destination_topic.empty())
    topics.push_back({merged.cloud_destination_topic, TopicKind::cloud});
}

void add_virtual(const VirtualScanConfig& group, std::vector<OutputTopic>& topics) {
  for (const auto& frame : group.virtual_laser_scan) {
    topics.push_back({group.topic(frame), TopicKind::scan});
    for (const auto& also : group.also) topics.push_back({group.topic(frame, &also), TopicKind::scan});
    if (!group.output_laser_topic.empty()) break;
  }
}

/// True if the states of the device (inputs, outputs, fields) are published.
bool publishes_states(const SensorConfig& sensor) {
  // A CoLa device is asked for them; captures may hold what somebody else asked it for.
  return !sensor.model->has(Trait::states_on_request) || sensor.driver.requests.device_states;
}

/// What the device tells beside its frames.
void add_told(const SensorConfig& sensor, std::vector<OutputTopic>& topics) {
  const std::string below = sensor.name + "/";
  for (const MessageTopic& told : sensor.model->messages) {
    if (told.kind == message_kind<DeviceState>() && !publishes_states(sensor)) continue;
    topics.push_back({below + std::string(told.name), TopicKind::message, false, told.kind});
  }
  for (const auto name : sensor.model->extra_scans)
    topics.push_back({below + std::string(name), TopicKind::scan, false});
}

}  // namespace

OutputTopic frame_topic(const SensorConfig& sensor) {
  if (sensor.model != nullptr && sensor.model->kind == FrameKind::cloud)
    return {sensor.points_topic.empty() ? sensor.name + "/points" : sensor.points_topic, TopicKind::cloud};
  return {sensor.scan_topic.empty() ? sensor.name + "/scan" : sensor.scan_topic, TopicKind::scan};
}

std::vector<OutputTopic> sensor_topics(const SensorConfig& sensor) {
  std::vector<OutputTopic> topics;
  if (sensor.model == nullptr) return topics;
  topics.push_back(frame_topic(sensor));
  if (sensor.ring_scan) topics.push_back({sensor.scan_topic, TopicKind::scan});
  if (sensor.model->has(Trait::echoes) && sensor.driver.publish_multiecho)
    topics.push_back({sensor.name + "/echoes", TopicKind::echoes});
  add_told(sensor, topics);
  return topics;
}

const OutputTopic& topic_named(const std::vector<OutputTopic>& topics, const std::string& name) {
  for (const OutputTopic& topic : topics) {
    if (topic.name == name) return topic;
  }
  throw std::logic_error("no topic " + name + " in the list");
}

std::vector<OutputTopic> output_topics(const Config& config) {
  std::vector<OutputTopic> topics;
  for (const auto& sensor : config.sensors) {
    for (auto& topic : sensor_topics(sensor)) topics.push_back(std::move(topic));
  }
  for (const auto& merged : config.merged_scans) add_merged(merged, topics);
  for (const auto& group : config.virtual_scans) add_virtual(group, topics);
  for (std::size_t id = 0; id < topics.size(); ++id) topics[id].id = id;
  return topics;
}

}  // namespace lidard
