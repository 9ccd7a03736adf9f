// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/offline/forecast.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/yaml/yaml.h"

namespace lidard {
namespace {

constexpr double unknown_reach = std::numeric_limits<double>::infinity();

/// Checks a configuration without data: poses that come only from tf, sources of other nodes, and outputs
/// that can never come.
class Forecast {
 public:
  /// `sights`: what its outputs can know.
  Forecast(const Config& config, const std::vector<FieldSight>& sights)
      : config_(config),
        root_(parse_yaml(config.text, config.file)),
        sights_(sights),
        poses_(config.vehicle.base_frame, fixed_poses(config), no_tf_) {}

  /// Each sentence begins with `file:line:column`.
  std::vector<std::string> all() {
    for (const SensorConfig& sensor : config_.sensors) check(sensor);
    for (const MergedScanConfig& merged : config_.merged_scans) check(merged);
    for (const MergedCloudConfig& merged : config_.merged_clouds) check(merged);
    for (const VirtualScanConfig& group : config_.virtual_scans) check(group);
    return std::move(sentences_);
  }

 private:
  std::optional<Pose> pose_of(const std::string& parent, const std::string& child) const {
    Pose pose;
    std::string why;
    return poses_.find(parent, child, Stamp{}, pose, why) ? std::optional<Pose>(pose) : std::nullopt;
  }
  bool is_known(const std::string& parent, const std::string& child) const {
    return pose_of(parent, child).has_value();
  }
  /// True if the pose of a source (sensor or virtual scan) in `frame` is configured.
  bool has_pose(const std::string& source, const std::string& frame) const {
    if (const SensorConfig* sensor = config_.find_sensor(source)) {
      // The frame of another driver's messages is known only at run time.
      if (sensor->model == nullptr && !sensor->pose) return false;
      return is_known(frame, sensor->frame_id);
    }
    for (const VirtualScanConfig& group : config_.virtual_scans) {
      for (const std::string& origin : group.virtual_laser_scan) {
        if (group.topic(origin) == source) return is_known(frame, origin);
      }
    }
    return false;
  }
  void add(const Value& entry, const std::string& sentence) {
    sentences_.push_back(entry.key_location().to_string() + ": " + entry.path() + ": " + sentence);
  }
  /// `unknown`: frames without configured pose; `lost`: the complete output needs them.
  void check_poses(const Value& entry, const std::set<std::string>& unknown, bool lost) {
    if (unknown.empty()) return;
    std::string list;
    for (const std::string& name : unknown) list += (list.empty() ? "" : ", ") + name;
    const std::string begin = unknown.size() == 1 ? "the pose of " + list + " comes from tf only"
                                                  : "the poses of " + list + " come from tf only";
    add(entry, begin + "; without tf (replay --bag, snapshot) " +
                   (lost ? "nothing comes out" : "what needs it is left out") + ": configure it");
  }
  void check_topics(const Value& entry, const std::vector<std::string>& sources) {
    for (const std::string& source : sources) {
      const SensorConfig* sensor = config_.find_sensor(source);
      if (sensor == nullptr || sensor->model != nullptr) continue;
      add(entry, source + " comes from " + sensor->topic +
                     ", which another node must publish; a replay has it if a bag does");
    }
  }
  /// m from `frame` that a sensor proves free without a return, `most` by the settings of its output.
  double proven_by(const SensorConfig* sensor, const std::string& frame, double most) const {
    if (sensor == nullptr || sensor->model == nullptr || sensor->model->range_max <= 0) return most;
    const double own = std::min(most, sensor->model->range_max), limit = sensor->driver.max_range;
    const auto pose = pose_of(frame, sensor->frame_id);
    return pose ? (limit > 0 ? std::min(own, limit) : own) + pose->translation().norm() : unknown_reach;
  }
  /// Checks that the sources prove as much free as a free beam requires; `free_required`: 0: range_max.
  template <class Output>
  void question_reach(const Value& entry, const Output& output, double proven, double free_required = 0) {
    const double range_max = output.output.grid.range_max;
    const double wanted = free_required > 0 ? std::min(free_required, range_max) : range_max;
    if (output.has_visibility() && output.output.unobserved == EmptyBeam::inf)
      add(value_at(entry, "unobserved"), "is inf: what nobody has seen looks as what is free");
    if (!output.has_visibility() || wanted <= proven) return;
    const Value key = value_at(entry, free_required > 0 ? "free_required" : "range_max");
    add(key, "is " + number_text(wanted) + " m, and without return its sources prove no more than " +
                 printed("%.1f m free (by their range and no_return_free_range): in an open field no beam of "
                         "profile strict or safety is free (+inf)",
                         proven));
  }
  bool is_merged(const std::string& topic) const {
    return std::any_of(config_.merged_scans.begin(), config_.merged_scans.end(), [&](const auto& merged) {
      const auto& sources = merged.laserscan_topics;
      return sources.size() > 1 && std::find(sources.begin(), sources.end(), topic) != sources.end();
    });
  }
  /// Virtual scans that clear nothing, unless scanners are merged with them.
  void question_origins(const Value& entry, const VirtualScanConfig& group, const std::string& lidar) {
    constexpr double most = 50;
    for (const FieldSight& sight : sights_) {
      if (sight.entry != "virtual_scans." + group.name + "." + sight.frame || !sight.proves ||
          is_merged(sight.topic))
        continue;
      for (const Hindrance& one : sight.hindrances) {
        if (one.limit != Limit::elevations || one.beams.all < most) continue;
        add(entry, sight.frame + " lies where " + lidar + " is blind: " + printed("%.0f", one.beams.all) +
                       " % of its beams begin unseen and are never free (+inf); merge it with scanners at "
                       "its height");
      }
    }
  }
  void check(const SensorConfig& sensor) {
    const Value entry = value_at(value_at(root_, "sensors"), sensor.name);
    const std::string& frame = sensor.points_frame;
    if (frame.empty() || has_pose(sensor.name, frame)) return;
    add(entry,
        "the pose of " + sensor.frame_id + " in points_frame " + frame +
            " comes from tf only; without tf (replay --bag, snapshot) its cloud does not come out: take a "
            "frame whose pose is configured, or name a bag with tf (--motion)");
  }
  void check(const MergedScanConfig& merged) {
    const Value entry = value_at(value_at(root_, "merged_scans"), merged.name);
    double proven = 0;
    for (const std::string& source : merged.laserscan_topics) {
      const SensorConfig* sensor = config_.find_sensor(source);
      const double free_range = merged.settings_of(source).no_return_free_range;
      proven = std::max(proven, proven_by(sensor, merged.destination_frame, free_range));
    }
    question_reach(entry, merged, proven, merged.free_required);
    check_merged(entry, merged, merged.laserscan_topics, !config_.vehicle.footprint.empty());
  }
  void check(const MergedCloudConfig& merged) {
    check_merged(value_at(value_at(root_, "merged_clouds"), merged.name), merged, merged.sources, true);
  }
  /// `on_vehicle`: the pose of the destination on the vehicle is needed, whatever the sources' frames are.
  template <class Merged>
  void check_merged(const Value& entry, const Merged& merged, const std::vector<std::string>& sources,
                    bool on_vehicle) {
    const bool is_lost = on_vehicle && !is_known(config_.vehicle.base_frame, merged.destination_frame);
    std::set<std::string> unknown;
    if (is_lost) unknown.insert("destination_frame " + merged.destination_frame);
    std::size_t lost = 0;
    for (const std::string& source : sources) {
      if (has_pose(source, merged.destination_frame)) continue;
      ++lost;
      if (!has_pose(source, config_.vehicle.base_frame)) unknown.insert(source);
      if (!is_known(config_.vehicle.base_frame, merged.destination_frame))
        unknown.insert("destination_frame " + merged.destination_frame);
    }
    check_poses(entry, unknown, is_lost || lost == sources.size());
    check_topics(entry, sources);
  }
  void check(const VirtualScanConfig& group) {
    const Value entry = value_at(value_at(root_, "virtual_scans"), group.name);
    const VehicleConfig& vehicle = config_.vehicle;
    const std::vector<std::string> lidars = config_.lidars_of(group);
    const double most = group.no_return_free_range > 0 ? group.no_return_free_range : unknown_reach;
    double proven = 0;
    for (const std::string& lidar : lidars) {
      for (const std::string& frame : group.virtual_laser_scan)
        proven = std::max(proven, proven_by(config_.find_sensor(lidar), frame, most));
    }
    question_reach(entry, group, proven);
    // Of several each sees where another one is blind.
    if (lidars.size() == 1) question_origins(entry, group, lidars[0]);
    std::set<std::string> without_pose, unknown;
    for (const std::string& lidar : lidars) {
      if (!has_pose(lidar, vehicle.base_frame)) without_pose.insert(lidar);
    }
    std::size_t lost = 0;
    for (const std::string& frame : group.virtual_laser_scan) {
      const auto with_pose = static_cast<std::size_t>(std::count_if(
          lidars.begin(), lidars.end(), [&](const std::string& lidar) { return has_pose(lidar, frame); }));
      if (with_pose == lidars.size()) continue;
      if (with_pose == 0) ++lost;
      if (!is_known(vehicle.base_frame, frame)) unknown.insert(frame);
      unknown.insert(without_pose.begin(), without_pose.end());
    }
    const bool on_vehicle = group.has_visibility() || !vehicle.footprint.empty() || vehicle.has_motion();
    if (on_vehicle) unknown.insert(without_pose.begin(), without_pose.end());
    const bool all_lost = on_vehicle && without_pose.size() == lidars.size();
    check_poses(entry, unknown, all_lost || lost == group.virtual_laser_scan.size());
    check_topics(entry, lidars);
  }

  const Config& config_;
  Value root_;
  const std::vector<FieldSight>& sights_;
  NoTransforms no_tf_;
  FrameTree poses_;
  std::vector<std::string> sentences_;
};

}  // namespace

std::vector<std::string> forecast(const Config& config, const std::vector<FieldSight>& sights) {
  return Forecast(config, sights).all();
}

}  // namespace lidard
