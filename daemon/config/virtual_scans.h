// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/virtual/virtualizer.h"
#include "daemon/config/outputs.h"

namespace lidard {

/// One entry of `virtual_scans:`.
struct VirtualScanConfig {
  std::string name;
  std::string cloud_topic;  ///< name of a sensor that gives clouds, or topic of a merged cloud
  std::string base_frame;   ///< parent of the poses
  std::vector<std::string> virtual_laser_scan;  ///< output frames
  std::map<std::string, Pose> poses;  ///< of output frames in base_frame; a frame without one comes from tf
  std::string output_laser_topic;     ///< empty: one topic per frame, named like the frame
  OutputScanConfig output;
  std::vector<AlsoScanConfig> also;  ///< topics beneath that of the frame
  CutMode mode = CutMode::slice;
  GroundSettings ground;
  bool early_returns = false;       ///< echoes: all
  double no_return_free_range = 0;  ///< m that a beam without return proves free
  bool has_visibility() const;
  /// Topic of a frame's scan, or of one of its further scans.
  std::string topic(const std::string& frame, const AlsoScanConfig* further = nullptr) const;
  std::vector<OutputTopic> topics() const;
};

/// What holds for a virtual scan before its keys are read.
VirtualScanConfig default_virtual_scan();
/// Of a scan that proves nothing the keys that say how do not apply.
Keys virtual_keys(VirtualScanConfig& scan);
void read_virtual_scans(const Mapping& root, Reading& reading);

}  // namespace lidard
