// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What a sensor publishes, and what comes from it.
#include <algorithm>

#include "daemon/config/sensors.h"

namespace lidard {
namespace {

/// Topics of the device's messages beside its frames.
void add_device_topics(const SensorConfig& sensor, std::vector<OutputTopic>& topics) {
  const std::string below = sensor.name + "/";
  const bool states = !sensor.model->has(Trait::states_on_request) || sensor.driver.requests.device_states;
  for (const MessageTopic& message : sensor.model->messages) {
    if (message.kind == message_kind<DeviceState>() && !states) continue;
    if (message.name == output_paths_topic && !sensor.output_paths_topic.empty()) continue;
    topics.push_back(
        {below + std::string(message.name), TopicKind::message, false, message.kind, 0, message.name});
  }
  if (!states) return;
  for (const auto name : sensor.model->extra_scans)
    topics.push_back({below + std::string(name), TopicKind::scan, false, 0, 0, name});
}

}  // namespace

std::vector<Flow> flows_of(const SensorConfig& sensor) {
  if (sensor.model == nullptr) return {};
  std::vector<Flow> flows = flows_of(*sensor.model, sensor.ip_address.value_or(IpAddress()), sensor.ip_port,
                                     sensor.telemetry_port, sensor.device_port());
  const auto is_foreign = [&](const Flow& flow) {
    // Another node receives the datagrams; a connection identifies a device only by address.
    return flow.transport == Transport::udp ? !sensor.packet_topic.empty() : !sensor.ip_address;
  };
  flows.erase(std::remove_if(flows.begin(), flows.end(), is_foreign), flows.end());
  return flows;
}

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
  if (!sensor.raw_topic.empty())
    topics.push_back({sensor.raw_topic, TopicKind::message, true, message_kind<RawPackets>()});
  if (!sensor.extended_scan_topic.empty())
    topics.push_back({sensor.extended_scan_topic, TopicKind::extended_scan});
  if (!sensor.output_paths_topic.empty())
    topics.push_back({sensor.output_paths_topic, TopicKind::output_paths, false, 0, 0, output_paths_topic});
  add_device_topics(sensor, topics);
  return topics;
}

}  // namespace lidard
