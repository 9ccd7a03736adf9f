// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/output_topics.h"

#include <utility>

namespace lidard {
namespace {

void add_merged(const MergedScanConfig& merged, std::vector<OutputTopic>& topics) {
  topics.push_back({{merged.scan_destination_topic, TopicKind::scan}, true});
  if (!merged.status_topic.empty()) topics.push_back({{merged.status_topic, TopicKind::scan}, true});
  for (const auto& also : merged.also) topics.push_back({{also.topic, TopicKind::scan}, true});
  if (!merged.cloud_destination_topic.empty())
    topics.push_back({{merged.cloud_destination_topic, TopicKind::cloud}, true});
}

void add_virtual(const VirtualScanConfig& group, std::vector<OutputTopic>& topics) {
  for (const auto& frame : group.virtual_laser_scan) {
    topics.push_back({{group.topic(frame), TopicKind::scan}, true});
    for (const auto& also : group.also)
      topics.push_back({{group.topic(frame, &also), TopicKind::scan}, true});
    if (!group.output_laser_topic.empty()) break;
  }
}

/// What the device tells beside its frames.
void add_told(const SensorConfig& sensor, std::vector<OutputTopic>& topics) {
  const auto add = [&](std::string_view name, TopicKind kind) {
    topics.push_back({{sensor.name + "/" + std::string(name), kind}, false});
  };
  if (sensor.model->has(Trait::gnss)) {
    add("fix", TopicKind::fix);
    add("time_reference", TopicKind::time_reference);
  }
  if (sensor.model->has(Trait::imu)) add("imu", TopicKind::imu);
  if (publishes_states(sensor))
    for (const auto name : sensor.model->state_topics) add(name, TopicKind::state);
  for (const auto name : sensor.model->extra_scans) add(name, TopicKind::scan);
}

}  // namespace

TopicInfo frame_topic(const SensorConfig& sensor) {
  if (sensor.model != nullptr && sensor.model->kind == FrameKind::cloud)
    return {sensor.points_topic.empty() ? sensor.name + "/points" : sensor.points_topic, TopicKind::cloud};
  return {sensor.scan_topic.empty() ? sensor.name + "/scan" : sensor.scan_topic, TopicKind::scan};
}

bool publishes_states(const SensorConfig& sensor) {
  // A CoLa device is asked for them; captures may hold what somebody else asked it for.
  return !sensor.model->has(Trait::states_on_request) || sensor.driver.requests.device_states;
}

std::vector<OutputTopic> sensor_topics(const SensorConfig& sensor) {
  std::vector<OutputTopic> topics;
  if (sensor.model == nullptr) return topics;
  topics.push_back({frame_topic(sensor), true});
  if (sensor.ring_scan) topics.push_back({{sensor.scan_topic, TopicKind::scan}, true});
  if (sensor.model->has(Trait::echoes) && sensor.driver.publish_multiecho)
    topics.push_back({{sensor.name + "/echoes", TopicKind::echoes}, true});
  add_told(sensor, topics);
  return topics;
}

std::vector<OutputTopic> output_topics(const Config& config) {
  std::vector<OutputTopic> topics;
  for (const auto& sensor : config.sensors) {
    for (auto& topic : sensor_topics(sensor)) topics.push_back(std::move(topic));
  }
  for (const auto& merged : config.merged_scans) add_merged(merged, topics);
  for (const auto& group : config.virtual_scans) add_virtual(group, topics);
  return topics;
}

std::vector<TopicInfo> pipeline_topics(const Config& config) {
  std::vector<TopicInfo> topics;
  for (auto& topic : output_topics(config)) topics.push_back(std::move(topic.info));
  return topics;
}

}  // namespace lidard
