// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

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

  void scan(const OutputTopic& topic, const PlanarScan& scan, Stamp released) override;
  void cloud(const OutputTopic& topic, Cloud& cloud, Stamp released) override;

  /// The newest of them, or nullptr.
  const PlanarScan* find_scan(const std::string& topic, const std::string& frame) const;
  const Cloud* find_cloud(const std::string& topic) const;
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
