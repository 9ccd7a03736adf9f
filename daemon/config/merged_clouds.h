// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/config/schedule.h"
#include "daemon/config/topic.h"

namespace lidard {

/// One entry of `merged_clouds:`.
struct MergedCloudConfig {
  std::string name;
  std::vector<std::string>
      sources;  ///< names of sensors; a return's `sensor` is the index of its source here
  std::string destination_frame;
  std::optional<Pose> destination_pose;  ///< as in MergedScanConfig
  std::string destination_topic;         ///< default: the entry's name
  bool organized = false;                ///< a row per ring, else a list
  ScheduleSettings schedule;
  MissingMotion on_missing_motion = MissingMotion::stand;

  std::vector<OutputTopic> topics() const { return {{destination_topic, TopicKind::merged_cloud}}; }
};

Keys merged_cloud_keys(MergedCloudConfig& merged);
void read_merged_clouds(const Mapping& root, Reading& reading);

}  // namespace lidard
