// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include "daemon/pipeline.h"
#include "daemon/sensor_line.h"

namespace lidard {

std::vector<TopicInfo> pipeline_topics(const Config& config) {
  std::vector<TopicInfo> topics;
  for (const auto& sensor : config.sensors) {
    for (auto& topic : sensor_topics(sensor)) topics.push_back(std::move(topic));
  }
  for (const auto& merged : config.merged_scans) {
    topics.push_back({merged.scan_destination_topic, TopicKind::scan});
    if (!merged.status_topic.empty()) topics.push_back({merged.status_topic, TopicKind::scan});
    for (const auto& also : merged.also) topics.push_back({also.topic, TopicKind::scan});
    if (!merged.cloud_destination_topic.empty())
      topics.push_back({merged.cloud_destination_topic, TopicKind::cloud});
  }
  for (const auto& group : config.virtual_scans) {
    for (const auto& frame : group.virtual_laser_scan) {
      topics.push_back({group.topic(frame), TopicKind::scan});
      for (const auto& also : group.also) topics.push_back({group.topic(frame, &also), TopicKind::scan});
      if (!group.output_laser_topic.empty()) break;
    }
  }
  return topics;
}

}  // namespace lidard
