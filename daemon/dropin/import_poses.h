// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "daemon/dropin/launch_file.h"

namespace lidard {

/// A configuration equivalent to nodes of other packages. The lists contain every parameter, pose and node
/// without counterpart.
struct ImportedConfig {
  Sections keys;
  std::vector<std::string> changes;  ///< changes of outputs, poses and topics
  std::vector<std::string> stays;    ///< nodes and transforms that are needed in a launch file as before
  std::vector<std::string> remarks;  ///< parameters and nodes that are not needed

  /// The number of sensors, merged and virtual scans.
  std::size_t entries() const {
    return keys.sensors.size() + keys.merged_scans.size() + keys.virtual_scans.size();
  }
};

/// The static transforms of imported nodes, and the poses that they make in a configuration.
class ImportPoses {
 public:
  /// Adds what static_transform_publisher or a joint of a robot's description publishes; false: it is no
  /// transform.
  bool add_publisher(const LaunchNode& node);
  /// Adds what a driver publishes; other publishers of a frame count before drivers.
  void add_driver(const LaunchNode& node, const StaticTransform& transform);
  /// Names the base frame; the first one counts.
  void set_base(const std::string& frame);
  /// Names the odometry frame, and a frame that moves in it. Returns that of the vehicle, the first one.
  std::string set_odometry(const std::string& frame, const std::string& moved) {
    if (odometry_.empty()) odometry_ = frame, moved_ = moved;
    return odometry_;
  }
  /// Sets all poses and the vehicle's keys, and reports the other transforms. Throws ConfigError for a loop.
  void apply(ImportedConfig& config);

 private:
  struct Transform {
    std::string publisher;
    bool is_joint;
    StaticTransform fixed;
  };
  const Transform* above(const std::string& frame) const;
  std::optional<Pose> pose_of(std::string frame, std::string& root);
  void refuse_loops() const;
  void choose_base(ImportedConfig& config);
  void report_unused(ImportedConfig& config);

  std::deque<Transform> transforms_;
  std::set<const Transform*> used_;  // parts of a pose
  std::string base_, odometry_, moved_;
};

}  // namespace lidard
