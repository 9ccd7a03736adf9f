// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/evidence/placed_scan.h"
#include "daemon/config/outputs.h"
#include "daemon/config/schedule.h"

namespace lidard {

/// One entry of `merged_scans:`.
struct MergedScanConfig {
  std::string name;
  std::vector<std::string> laserscan_topics;  ///< names of sensors
  std::string destination_frame;
  std::optional<Pose>
      destination_pose;                ///< of destination_frame in base_frame; identity for base_frame itself
  std::string scan_destination_topic;  ///< default: the entry's name
  std::string cloud_destination_topic;  ///< empty: no cloud
  ScheduleSettings schedule;
  MissingMotion on_missing_motion = MissingMotion::stand;
  std::string status_topic;  ///< what is known of each beam, as a LaserScan; empty: none
  OutputScanConfig output;
  std::vector<AlsoScanConfig> also;
  SourceSettings source;                                  ///< of a source without an entry in source_settings
  std::map<std::string, SourceSettings> source_settings;  ///< of sources that differ from the rest, by name
  double free_required = 0;                ///< m that a beam must be observed to be free; 0: range_max
  std::vector<std::string> free_requires;  ///< sources of which one must see a free beam's way; empty: any

  /// True if some scan of this merge is more than points.
  bool has_visibility() const;
  std::vector<OutputTopic> topics() const;
  const SourceSettings& settings_of(const std::string& source_name) const {
    const auto own = source_settings.find(source_name);
    return own == source_settings.end() ? source : own->second;
  }
};

Keys merged_keys(MergedScanConfig& merged);
/// Of an entry of `source_settings:`.
Keys source_keys(SourceSettings& settings);
void read_merged_scans(const Mapping& root, std::vector<MergedScanConfig>& merged_scans, Reading& reading);

}  // namespace lidard
