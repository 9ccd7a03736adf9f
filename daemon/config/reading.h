// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/config/yaml_reader.h"

namespace lidard {

/// What must be unique among all parts of a configuration, gathered while they are read.
class ConfigClaims {
 public:
  ConfigClaims();
  /// Records that `owner` publishes on `topic`; throws at `value` if another owner does.
  void publishes(const std::string& topic, const std::string& owner, const Value& value);
  /// Notes that a sensor listens to `topic`.
  void listens(const std::string& topic, const std::string& owner, const Value& value);
  /// Notes the pose of `child` in `parent`; throws at `value` if it has another one already.
  void holds_frame(const std::string& child, const std::string& parent, const Pose& pose,
                   const std::string& owner, const Value& value);
  /// Notes what `owner` takes a sensor for; throws if a source with `topic:` was taken for the other kind.
  void uses(const SensorConfig& sensor, FrameKind kind, const std::string& owner, const Value& value);
  bool is_used(const std::string& sensor) const { return uses_.count(sensor) != 0; }

 private:
  struct Frame {
    std::string parent;
    Pose pose;
    std::string owner;
  };
  struct Use {
    FrameKind kind;
    std::string owner;
  };
  std::map<std::string, std::string> topics_;  // without leading slash, to the owner
  std::map<std::string, Frame> frames_;
  std::map<std::string, Use> uses_;
};

/// A configuration while it is read.
struct Reading {
  Config config;
  ConfigClaims claims;
  std::set<std::string> invalid_names;  ///< without leading slash
  bool is_complete = true;              ///< false if the file has unknown sections
  bool is_vehicle_valid = true;

  /// Keeps a remark that is no error.
  void warn(const Place& place, const std::string& what);
  /// Keeps the names of an invalid entry: its own and every text in it, which may be a topic or a frame.
  void add_invalid_names(const std::string& name, const Value& entry);
  /// True if `name` may belong to something that is left out because of a mistake.
  bool may_be_invalid(const std::string& name) const;
};

/// A pose from {xyz: m, rpy: rad or rpy_deg}.
Pose read_pose(const Value& value);
/// A frame's name without leading slash (tf2 has none).
std::string read_frame(const Value& value);
/// A ROS topic name.
std::string read_topic(const Value& value);
/// `name` itself if it can be part of a topic name; throws at the key otherwise.
void check_entry_name(const std::string& name, const Value& value);
/// A topic or frame as it is compared with others.
std::string without_slash(const std::string& name);
/// Roll, pitch, yaw (fixed axes, rad) that make_pose() turns into the rotation of `pose`.
Eigen::Vector3d rpy_of(const Pose& pose);

/// What a name in laserscan_topics, sources or cloud_topic stands for: a sensor, a virtual scan or a merged
/// cloud. One of them is set.
struct NamedSource {
  const SensorConfig* sensor = nullptr;
  const VirtualScanConfig* virtual_group = nullptr;
  std::string name;  ///< of the sensor, or the topic of the other as it is published
  const MergedCloudConfig* merged_cloud = nullptr;
};

/// The sensors that give frames of this kind, for messages.
std::string names_of(const Config& config, FrameKind kind);
/// What `value` names: a sensor by its name, by the topic it listens to or by the topic it publishes frames
/// of this kind on; or, where scans are wanted, a virtual scan by its topic; or, where clouds are, a merged
/// cloud by its name or its topic. A leading slash is of no importance. Throws if that is nothing, several
/// things, or something that gives frames of another kind; `expected` says what may be named.
NamedSource read_source(const Value& value, FrameKind kind, const Reading& reading,
                        const std::string& expected);
/// The topics of virtual scans that carry scans of one frame each.
std::vector<std::string> virtual_topics(const Config& config);

}  // namespace lidard
