// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/reading.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/base/nearest.h"
#include "daemon/config/config.h"

namespace lidard {
namespace {

constexpr double vehicle_size_m = 1000;  // a vehicle is smaller; millimetres written for metres are not

bool is_word_character(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// The rules of ROS names: `/` or a letter first; then letters, digits, `_`, single `/`. Private names (`~x`)
/// are no topics to roscpp's NodeHandle.
bool is_topic_name(const std::string& name) {
  const std::size_t first = name.find_first_not_of('/');
  if (first > 1 || name.find("//") != std::string::npos) return false;  // npos is greater, too
  if (std::isalpha(static_cast<unsigned char>(name[first])) == 0 || name.back() == '/') return false;
  return std::all_of(name.begin() + static_cast<std::ptrdiff_t>(first), name.end(),
                     [](char c) { return is_word_character(c) || c == '/'; });
}

std::string kind_of(const SensorConfig& sensor) {
  const bool cloud = sensor.model->kind == FrameKind::cloud;
  return std::string(sensor.model->name) + (cloud ? ", which gives clouds" : ", which gives scans");
}

bool can_give(const SensorConfig& sensor, FrameKind kind) {
  if (kind == FrameKind::scan && sensor.ring_scan) return true;
  return sensor.model == nullptr || sensor.model->kind == kind;
}

/// A name by which something may be called, and what it is.
struct Candidate {
  std::string called;  // as in the configuration
  FrameKind kind;      // of the frames under that name
  NamedSource source;
  std::string what;  // for messages
};

void add_sensor(const SensorConfig& sensor, FrameKind wanted, std::vector<Candidate>& candidates) {
  const NamedSource source{&sensor, nullptr, sensor.name, nullptr};
  const std::string path = "sensors." + sensor.name;
  candidates.push_back({sensor.name, can_give(sensor, wanted) ? wanted : sensor.model->kind, source, path});
  if (sensor.model == nullptr) {
    candidates.push_back({sensor.topic, wanted, source, "the topic of " + path});
    return;
  }
  for (const OutputTopic& topic : sensor_topics(sensor)) {
    const TopicKind kind = topic.kind;
    if (!topic.promised || (kind != TopicKind::scan && kind != TopicKind::cloud)) continue;
    candidates.push_back({topic.name, kind == TopicKind::cloud ? FrameKind::cloud : FrameKind::scan, source,
                          "the topic of " + path});
  }
}

/// Groups whose topics carry the scans of one frame each.
bool has_own_topics(const VirtualScanConfig& group) {
  return group.output_laser_topic.empty() || group.virtual_laser_scan.size() == 1;
}

std::vector<Candidate> candidates_of(const Config& config, FrameKind wanted) {
  std::vector<Candidate> candidates;
  for (const SensorConfig& sensor : config.sensors) add_sensor(sensor, wanted, candidates);
  for (const MergedCloudConfig& merged : config.merged_clouds) {
    for (const std::string& name : {merged.name, merged.destination_topic})
      candidates.push_back({name,
                            FrameKind::cloud,
                            {nullptr, nullptr, merged.destination_topic, &merged},
                            "merged_clouds." + merged.name});
  }
  for (const VirtualScanConfig& group : config.virtual_scans) {
    if (!has_own_topics(group)) continue;
    for (const std::string& frame : group.virtual_laser_scan)
      candidates.push_back({group.topic(frame),
                            FrameKind::scan,
                            {nullptr, &group, group.topic(frame), nullptr},
                            "the topic of virtual_scans." + group.name});
  }
  return candidates;
}

bool same_source(const Candidate& a, const Candidate& b) {
  return a.source.sensor == b.source.sensor && a.source.name == b.source.name;
}

}  // namespace

std::string without_slash(const std::string& name) {
  return name.substr(name.compare(0, 1, "/") == 0 ? 1 : 0);
}

Pose read_pose(const Value& value) {
  const Mapping pose(value, {"xyz", "rpy", "rpy_deg"});
  const std::string expected = "{xyz: [x, y, z], rpy_deg: [roll, pitch, yaw]}";
  const std::vector<double> xyz = pose.require("xyz", expected).numbers(3, vehicle_size_m, "m");
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  pose.in_rad("rpy", [&](const Value& angles, double to_rad) {
    const bool rad = to_rad == 1;
    const auto list =
        angles.numbers(3, rad ? most_turn_rad : 400, rad ? "rad (degrees: rpy_deg)" : "degrees");
    rpy = Eigen::Vector3d(list[0], list[1], list[2]) * to_rad;
  });
  Pose made = make_pose({xyz[0], xyz[1], xyz[2]}, rpy);
  if (!is_rigid(made)) value.fail("is not rigid", expected);
  return made;
}

Eigen::Vector3d rpy_of(const Pose& pose) {
  const Eigen::Matrix3d& r = pose.linear();
  const double level = std::hypot(r(0, 0), r(1, 0));
  const double pitch = std::atan2(-r(2, 0), level);
  // Looking straight up or down, roll and yaw turn about one axis: all of it counts as yaw.
  if (level < 1e-7) return {0, pitch, std::atan2(-r(0, 1), r(1, 1))};
  return {std::atan2(r(2, 1), r(2, 2)), pitch, std::atan2(r(1, 0), r(0, 0))};
}

std::string read_frame(const Value& value) {
  const std::string expected = "the name of a tf frame, without blanks";
  std::string name = without_slash(value.text(expected));
  const bool blank =
      std::any_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) <= ' '; });
  if (name.empty() || name.front() == '/' || blank) value.fail("is " + value.quoted(), expected);
  return name;
}

std::string read_topic(const Value& value) {
  const std::string expected = "a topic name: letters, digits, _ and /";
  std::string name = value.text(expected);
  if (!is_topic_name(name)) value.fail("is " + value.quoted(), expected);
  return name;
}

void check_entry_name(const std::string& name, const Value& value) {
  const bool good = std::isalpha(static_cast<unsigned char>(name.front())) != 0 &&
                    std::all_of(name.begin(), name.end(), is_word_character);
  if (!good)
    value.fail_at_key("cannot be part of a topic name", "a letter, then letters, digits and underscores");
}

void Reading::warn(const Place& place, const std::string& what) {
  config.warnings.push_back(place.to_string() + ": " + what);
}

void Reading::add_invalid_names(const std::string& name, const Value& entry) {
  constexpr int deepest = 3;  // an alias may hold itself
  invalid_names.insert(name);
  const std::function<void(const YAML::Node&, int)> add = [&](const YAML::Node& node, int level) {
    if (node.IsScalar()) invalid_names.insert(without_slash(node.Scalar()));
    if (level == deepest) return;
    for (const auto& child : node) add(node.IsMap() ? child.second : child, level + 1);
  };
  add(entry.node(), 0);
}

bool Reading::may_be_invalid(const std::string& name) const {
  return !is_complete || config.sensors.empty() || invalid_names.count(name) != 0 ||
         invalid_names.count(name.substr(0, name.find('/'))) != 0;
}

ConfigClaims::ConfigClaims() {
  for (const char* topic : {"clock", "diagnostics", "rosout", "tf", "tf_static"})
    topics_.emplace(topic, "ROS itself");
}

void ConfigClaims::publishes(const std::string& topic, const std::string& owner, const Value& value) {
  const auto [claim, is_new] = topics_.emplace(without_slash(topic), owner);
  if (!is_new)
    value.fail("would publish on " + topic + ", the topic of " + claim->second, "a topic of its own");
}

void ConfigClaims::listens(const std::string& topic, const std::string& owner, const Value& value) {
  const auto [claim, is_new] = topics_.emplace(without_slash(topic), owner);
  if (!is_new) value.fail("is the topic of " + claim->second + " already", "the topic of another driver");
}

void ConfigClaims::holds_frame(const std::string& child, const std::string& parent, const Pose& pose,
                               const std::string& owner, const Value& value) {
  if (child == parent) {
    if (!pose.isApprox(Pose::Identity(), 1e-9))
      value.fail("moves " + child + " against itself", "no pose, or another frame");
    return;
  }
  // tf knows a tree: a frame that hangs from itself would lose its parent.
  for (auto up = frames_.find(parent); up != frames_.end(); up = frames_.find(up->second.parent)) {
    if (up->second.parent == child)
      value.fail("places " + child + " in " + parent + ", which the pose of " + up->first + " in " +
                     up->second.owner + " places in " + child,
                 "poses that lead from each frame up to vehicle.base_frame");
  }
  const auto [frame, is_new] = frames_.emplace(child, Frame{parent, pose, owner});
  if (is_new) return;
  if (frame->second.parent != parent || !frame->second.pose.isApprox(pose, 1e-9))
    value.fail("differs from the pose of frame " + child + " in " + frame->second.owner,
               "one pose for one frame");
}

void ConfigClaims::uses(const SensorConfig& sensor, FrameKind kind, const std::string& owner,
                        const Value& value) {
  if (sensor.model != nullptr) return;
  const auto [use, is_new] = uses_.emplace(sensor.name, Use{kind, owner});
  if (is_new || use->second.kind == kind) return;
  const char* earlier = kind == FrameKind::scan ? "a cloud" : "a scan";
  value.fail("names " + sensor.name + ", which " + use->second.owner + " takes for " + earlier,
             "a topic to be one or the other");
}

std::string names_of(const Config& config, FrameKind kind) {
  std::string list;
  for (const SensorConfig& sensor : config.sensors) {
    if (can_give(sensor, kind)) list += (list.empty() ? "" : ", ") + sensor.name;
  }
  return list.empty() ? "none is configured" : list;
}

NamedSource read_source(const Value& value, FrameKind kind, const Reading& reading,
                        const std::string& expected) {
  const std::string name = without_slash(value.text(expected));
  const std::vector<Candidate> candidates = candidates_of(reading.config, kind);
  const Candidate* found = nullptr;
  const Candidate* other_kind = nullptr;
  for (const Candidate& one : candidates) {
    if (without_slash(one.called) != name) continue;
    if (one.kind != kind) {
      other_kind = &one;
    } else if (found == nullptr) {
      found = &one;
    } else if (!same_source(*found, one)) {
      value.fail("names " + value.quoted() + ", which is " + found->what + " and " + one.what,
                 "a name that only one of them has");
    }
  }
  if (found != nullptr && found->source.sensor == nullptr && other_kind != nullptr &&
      other_kind->source.sensor != nullptr)
    value.fail("names " + value.quoted() + ", which is " + found->what + " and " + other_kind->what,
               "a name that only one of them has");
  if (found != nullptr) return found->source;
  if (reading.may_be_invalid(name)) throw ConfigError(std::vector<ConfigError::Mistake>());
  if (other_kind == nullptr) {
    std::vector<std::string_view> names;
    for (const Candidate& one : candidates) {
      if (one.kind == kind) names.push_back(one.called);
    }
    const std::string_view near = nearest_word(name, names);
    value.fail("names " + value.quoted() + ", which is no sensor and no topic of one",
               near.empty() ? expected : std::string(near));
  }
  if (other_kind->source.sensor == nullptr)
    value.fail("names " + other_kind->called +
                   (other_kind->source.merged_cloud != nullptr ? ", a merged cloud, which gives no scans"
                                                               : ", a virtual scan, which gives no clouds"),
               expected);
  value.fail("names " + other_kind->called + ", " +
                 (other_kind->called == other_kind->source.name ? "a " : "of a ") +
                 kind_of(*other_kind->source.sensor),
             expected);
}

std::vector<std::string> virtual_topics(const Config& config) {
  std::vector<std::string> topics;
  for (const VirtualScanConfig& group : config.virtual_scans) {
    if (!has_own_topics(group)) continue;
    for (const std::string& frame : group.virtual_laser_scan) topics.push_back(group.topic(frame));
  }
  return topics;
}

}  // namespace lidard
