// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/config/yaml_reader.h"

namespace lidard {

/// What must be unique among all parts of a configuration, gathered while they are read.
class ConfigClaims {
 public:
  ConfigClaims();
  /// Notes that `owner` publishes on `topic`; throws at `value` if somebody else does.
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

/// Reads the sections into `config`; `claims` sees every name they give away.
void read_sensors(Mapping& root, Config& config, ConfigClaims& claims);
void read_merged_scans(Mapping& root, Config& config, ConfigClaims& claims);
void read_virtual_scans(Mapping& root, Config& config, ConfigClaims& claims);

/// The keys skip and publish_states of a device whose settings they are.
void read_cola_requests(Mapping& yaml, DeviceRequests& requests);
/// Keys of multi-plane lidars; the calibration was read already.
void read_cloud_keys(Mapping& yaml, SensorConfig& sensor);
/// `control:` of a sensor whose other keys are read already.
VelodyneControl read_control(const Value& value, const SensorConfig& sensor, Config& config);
/// The value of `control:`, all keys.
void write_control(YAML::Emitter& yaml, const VelodyneControl& control);
/// Reads `calibration:` and `calibration_model:` of a sensor and the file itself.
void read_calibration(Mapping& yaml, SensorConfig& sensor, Config& config);

/// Reads what the device of a sensor may be asked for: allow_write, listen_only, udp_receiver_ip, user_level,
/// user_level_password, where its model knows them.
void read_requests(Mapping& yaml, SensorConfig& sensor);
/// The same as keys and texts.
std::vector<std::pair<std::string, std::string>> requests_text(const SensorConfig& sensor);
/// The profile that a word names; throws if it names none.
Profile read_profile(const Value& value);
/// An entry of `also:`.
AlsoScanConfig read_also(const std::string& topic, const Value& value);
EmptyBeam read_empty(const Value& value);
/// The word for it in a configuration.
const char* word_of(Profile profile);
const char* word_of(EmptyBeam beam);
const char* word_of(EchoChoice choice);
const char* word_of(Intensities choice);
/// The keys of a merged scan that say how surfaces and free space are found.
void read_visibility(Mapping& yaml, const std::string& owner, Config& config, ConfigClaims& claims,
                     MergedScanConfig& merged);

/// The keys of a merged scan for what it does beside what merges always do; the others are read already.
void read_merge_options(Mapping& yaml, MergedScanConfig& merged);

/// The keys of a merged scan that say when it is published. `written`: its sources as laserscan_topics names
/// them.
void read_schedule(Mapping& yaml, const std::vector<std::string>& written, MergedScanConfig& merged);
/// Windows and properties of single sources; the keys that hold for all of them are read already.
void read_source_settings(Mapping& yaml, const std::vector<std::string>& written, MergedScanConfig& merged);
/// Both as keys.
extern const std::vector<std::string_view> schedule_keys;
const char* word_of(MissingMotion what);
/// What `echoes` may be, by its word; throws if it is none.
EchoChoice read_echoes(const Value& value);

/// A pose from {xyz: m, rpy: rad or rpy_deg}.
Pose read_pose(const Value& value);
/// A frame's name without leading slash (tf2 has none).
std::string read_frame(const Value& value);
/// A ROS topic name.
std::string read_topic(const Value& value);
/// `name` itself if it can be part of a topic name; throws at the key otherwise.
void check_entry_name(const std::string& name, const Value& value);
/// Keeps a remark that is no error.
void warn(Config& config, const Place& place, const std::string& what);

/// Roll, pitch, yaw (fixed axes, rad) that make_pose() turns into the rotation of `pose`.
Eigen::Vector3d rpy_of(const Pose& pose);

}  // namespace lidard
