// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/import_poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/base/number_text.h"
#include "daemon/config/values.h"

namespace lidard {

/// x y z yaw pitch roll, or x y z qx qy qz qw; parent child [period].
bool ImportPoses::add_publisher(const LaunchNode& node) {
  std::vector<double> numbers;
  std::vector<std::string> frames;
  for (const auto& word : node.arguments) {
    const auto number = number_in<double>(word);
    if (number && frames.empty())
      numbers.push_back(*number);
    else
      frames.push_back(without_slash(word));
  }
  if ((numbers.size() != 6 && numbers.size() != 7) || frames.size() < 2) return false;
  Pose pose = make_pose({numbers[0], numbers[1], numbers[2]}, {numbers[5], numbers[4], numbers[3]});
  if (numbers.size() == 7) {
    const Eigen::Quaterniond turn(numbers[6], numbers[3], numbers[4], numbers[5]);
    pose.linear() = turn.normalized().toRotationMatrix();
  }
  transforms_.push_front({node.name, node.package == "robot_state_publisher", {frames[0], frames[1], pose}});
  return true;
}

void ImportPoses::add_driver(const LaunchNode& node, const StaticTransform& transform) {
  transforms_.push_back({node.name, false, transform});
}

void ImportPoses::set_base(const std::string& frame) {
  if (base_.empty()) base_ = without_slash(frame);
}

const ImportPoses::Transform* ImportPoses::above(const std::string& frame) const {
  const auto up = std::find_if(transforms_.begin(), transforms_.end(),
                               [&](const Transform& one) { return one.fixed.child == frame; });
  return up == transforms_.end() ? nullptr : &*up;
}

/// The pose of the frame in the base frame, through a chain of transforms. It ends, since apply() rejects
/// loops.
std::optional<Pose> ImportPoses::pose_of(std::string frame, std::string& root) {
  Pose pose = Pose::Identity();
  std::set<const Transform*> chain;
  for (root = frame; frame != base_; root = frame) {
    const Transform* const up = above(frame);
    if (up == nullptr) return std::nullopt;
    pose = up->fixed.pose * pose;
    chain.insert(up);
    frame = up->fixed.parent;
  }
  used_.merge(chain);
  pose.translation() = (pose.translation() * 1e9).array().round() / 1e9;
  return pose;
}

/// Throws ConfigError where a frame hangs from itself: then nothing has a root.
void ImportPoses::refuse_loops() const {
  for (const Transform& begin : transforms_) {
    std::string chain = begin.fixed.child;
    const Transform* up = &begin;
    for (std::size_t steps = 0; up != nullptr && steps < transforms_.size(); ++steps) {
      chain += " in " + up->fixed.parent;
      if (up->fixed.parent == begin.fixed.child)
        throw ConfigError("the static transforms form a loop: " + chain + "; expected one parent per frame");
      up = above(up->fixed.parent);
    }
  }
}

/// Where no node names it, base_link or the root of a sensor.
void ImportPoses::choose_base(ImportedConfig& config) {
  std::string root, found;
  for (auto& [name, sensor] : config.keys.sensors) {
    const std::string frame = without_slash(text_of(sensor, "frame_id"));
    if (!base_.empty() || frame.empty()) continue;
    base_ = "base_link";
    const bool is_below = pose_of(frame, root).has_value();
    if (!is_below) base_.clear();
    if (!is_below && found.empty() && root != frame && root != odometry_) found = root;
  }
  set_base(found);
  set_base(moved_);
  for (auto& [name, entry] : config.keys.virtual_scans)
    set_base(std::get<std::string>(std::get<KeyList>(*find_key(entry, "virtual_laser_scan")).front()));
}

void ImportPoses::apply(ImportedConfig& config) {
  refuse_loops();
  choose_base(config);
  std::string root;
  for (auto& [name, sensor] : config.keys.sensors) {
    const std::string frame = without_slash(text_of(sensor, "frame_id"));
    const auto pose = frame.empty() || frame == base_ ? std::nullopt : pose_of(frame, root);
    if (!pose) continue;
    sensor.emplace_back("pose", *pose);
    const Transform& last = *above(frame);
    if (last.is_joint && last.fixed.parent != base_)
      config.changes.push_back(
          fmt::format("sensors.{}: `pose` makes {} the parent of {}, which is {} by {}; keep one", name,
                      base_, frame, last.fixed.parent, last.publisher));
  }
  for (auto& [name, entry] : config.keys.virtual_scans) {
    KeyMap poses;
    for (const KeyValue& given : std::get<KeyList>(*find_key(entry, "virtual_laser_scan"))) {
      const std::string frame = without_slash(std::get<std::string>(given));
      if (const auto pose = pose_of(frame, root)) poses.emplace_back(frame, *pose);
    }
    if (!poses.empty()) entry.emplace_back("poses", poses);
  }
  report_unused(config);
  if (base_ == "map")
    config.changes.emplace_back("vehicle.base_frame is map, the default of sick_scan_xd; name yours");
  if (!base_.empty()) config.keys.vehicle.emplace_back("base_frame", base_);
  if (!odometry_.empty()) config.keys.vehicle.emplace_back("odometry_frame", odometry_);
}

/// Transforms that no sensor and no virtual scan hangs from.
void ImportPoses::report_unused(ImportedConfig& config) {
  std::map<std::string, std::string> owners;
  for (auto& [name, sensor] : config.keys.sensors)
    owners.emplace(without_slash(text_of(sensor, "frame_id")), "sensors." + name + ": ");
  for (const Transform& one : transforms_) {
    const auto owner = owners.find(one.fixed.child);
    const Transform* const instead = above(one.fixed.child);
    const bool is_same =
        instead->fixed.parent == one.fixed.parent && instead->fixed.pose.isApprox(one.fixed.pose);
    // A description's publisher goes on for frames that are no sensor's.
    if (used_.count(&one) > 0 || (one.is_joint && owner == owners.end())) continue;
    if (instead != &one && is_same) continue;
    std::string pose = yaml_text({{"pose", one.fixed.pose}});
    pose.pop_back();
    const std::string subject = fmt::format("the pose of {} in {}", one.fixed.child, one.fixed.parent);
    const std::string text =
        instead != &one
            ? fmt::format("{} by {} ({}) was left out: that by {} is another one", subject, one.publisher,
                          pose, instead->publisher)
            : fmt::format(
                  "{} is not part of this configuration, whose base_frame is {}: publish it on tf, {}",
                  subject, base_, pose);
    (owner == owners.end() ? config.stays : config.changes)
        .push_back((owner == owners.end() ? "" : owner->second) + text);
  }
}

}  // namespace lidard
