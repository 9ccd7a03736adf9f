// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/files/snapshot_frames.h"

#include <algorithm>

namespace lidard {

void FrameKeeper::scan(const OutputTopic& topic, const PlanarScan& scan, Stamp) {
  if (frozen_) return;
  scans_[{topic.name, scan.frame_id}] = scan;
  newest_ = std::max(newest_, scan.stamp);
}

void FrameKeeper::cloud(const OutputTopic& topic, Cloud& cloud, Stamp) {
  if (frozen_) return;
  clouds_[topic.name] = cloud;
  newest_ = std::max(newest_, cloud.stamp);
}

const PlanarScan* FrameKeeper::find_scan(const std::string& topic, const std::string& frame) const {
  const auto found = scans_.find({topic, frame});
  return found == scans_.end() ? nullptr : &found->second;
}

const Cloud* FrameKeeper::find_cloud(const std::string& topic) const {
  const auto found = clouds_.find(topic);
  return found == clouds_.end() ? nullptr : &found->second;
}

}  // namespace lidard
