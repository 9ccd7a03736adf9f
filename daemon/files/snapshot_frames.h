// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <map>
#include <utility>

#include "daemon/pipeline/sink.h"

namespace lidard {

/// Keeps the newest scan of each topic and frame, and the newest cloud of each topic.
class FrameKeeper : public FrameSink {
 public:
  /// By topic and frame: several virtual scans may share a topic.
  using Key = std::pair<std::string, std::string>;

  /// What comes after this call is not kept.
  void freeze() { frozen_ = true; }

  void scan(const OutputTopic& topic, const PlanarScan& scan, Stamp /*released*/) override {
    if (frozen_) return;
    scans_[{topic.name, scan.frame_id}] = scan;
    newest_ = std::max(newest_, scan.stamp);
  }
  void cloud(const OutputTopic& topic, Cloud& cloud, Stamp /*released*/) override {
    if (frozen_) return;
    clouds_[topic.name] = cloud;
    newest_ = std::max(newest_, cloud.stamp);
  }

  /// The newest of them, or nullptr.
  const PlanarScan* find_scan(const std::string& topic, const std::string& frame) const {
    const auto found = scans_.find({topic, frame});
    return found == scans_.end() ? nullptr : &found->second;
  }
  const Cloud* find_cloud(const std::string& topic) const {
    const auto found = clouds_.find(topic);
    return found == clouds_.end() ? nullptr : &found->second;
  }
  bool empty() const { return scans_.empty() && clouds_.empty(); }
  /// Stamp of the newest frame of all.
  Stamp newest() const { return newest_; }

 private:
  std::map<Key, PlanarScan> scans_;
  std::map<std::string, Cloud> clouds_;
  Stamp newest_{};
  bool frozen_ = false;
};

}  // namespace lidard
