// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <ostream>
#include <set>

#include "daemon/commands/commands.h"
#include "daemon/config/config.h"
#include "daemon/config/yaml_reader.h"
#include "daemon/files/text_table.h"
#include "daemon/pipeline/frame_tree.h"

namespace lidard {
namespace {

/// The value of a key of a mapping that was read before and is therefore there.
Value value_of(const Value& mapping, const std::string& key) {
  for (const auto& [name, value] : named_entries(mapping)) {
    if (name == key) return value;
  }
  return mapping;
}

/// What can be known of the outputs of a configuration without data: which poses only tf can tell, and which
/// sources only another node can give.
class Forecast {
 public:
  /// `text` is what `config` was read from.
  Forecast(const Config& config, const std::string& text)
      : config_(config), root_(parse_yaml(text, config.file)), poses_(config, no_tf_) {}

  /// Each sentence begins with `file:line:column`.
  std::vector<std::string> all() {
    for (const SensorConfig& sensor : config_.sensors) tell(sensor);
    for (const MergedScanConfig& merged : config_.merged_scans) tell(merged);
    for (const VirtualScanConfig& group : config_.virtual_scans) tell(group);
    return std::move(sentences_);
  }

 private:
  bool is_known(const std::string& parent, const std::string& child) const {
    Pose pose;
    std::string why;
    return poses_.find(parent, child, Stamp{}, pose, why);
  }
  /// Is the place of a source's frames in `frame` configured? A source is a sensor or a virtual scan.
  bool is_placed(const std::string& source, const std::string& frame) const {
    if (const SensorConfig* sensor = config_.find_sensor(source)) {
      // The frame of another driver's messages is known only when they come.
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
    sentences_.push_back(entry.key_place().to_string() + ": " + entry.path() + ": " + sentence);
  }
  /// `unknown`: what has no configured pose; `lost`: whether all of the output needs it.
  void tell_poses(const Value& entry, const std::set<std::string>& unknown, bool lost) {
    if (unknown.empty()) return;
    std::string list;
    for (const std::string& name : unknown) list += (list.empty() ? "" : ", ") + name;
    const std::string begin = unknown.size() == 1 ? "the pose of " + list + " comes from tf only"
                                                  : "the poses of " + list + " come from tf only";
    add(entry, begin + "; without tf (replay --bag, snapshot) " +
                   (lost ? "nothing comes out" : "what needs it is left out") + ": configure it");
  }
  void tell_topics(const Value& entry, const std::vector<std::string>& sources) {
    for (const std::string& source : sources) {
      const SensorConfig* sensor = config_.find_sensor(source);
      if (sensor == nullptr || sensor->model != nullptr) continue;
      add(entry, source + " comes from " + sensor->topic +
                     ", which another node must publish; a replay of captures is without it");
    }
  }
  void tell(const SensorConfig& sensor) {
    const std::string& frame = sensor.points_frame;
    if (frame.empty() || is_placed(sensor.name, frame)) return;
    add(value_of(value_of(root_, "sensors"), sensor.name),
        "the pose of " + sensor.frame_id + " in points_frame " + frame +
            " comes from tf only; without tf (replay --bag, snapshot) its cloud does not come out: take a "
            "frame whose pose is configured, or name a bag with tf (--motion)");
  }
  void tell(const MergedScanConfig& merged) {
    const Value entry = value_of(value_of(root_, "merged_scans"), merged.name);
    const std::string& base = config_.vehicle.base_frame;
    const std::string destination = "destination_frame " + merged.destination_frame;
    const bool destination_known = is_known(base, merged.destination_frame);
    std::set<std::string> unknown;
    std::size_t lost = 0;
    for (const std::string& source : merged.laserscan_topics) {
      if (is_placed(source, merged.destination_frame)) continue;
      ++lost;
      if (!is_placed(source, base)) unknown.insert(source);
      if (!destination_known) unknown.insert(destination);
    }
    const bool footprint_lost = !config_.vehicle.footprint.empty() && !destination_known;
    if (footprint_lost) unknown.insert(destination);
    tell_poses(entry, unknown, footprint_lost || lost == merged.laserscan_topics.size());
    tell_topics(entry, merged.laserscan_topics);
  }
  void tell(const VirtualScanConfig& group) {
    const Value entry = value_of(value_of(root_, "virtual_scans"), group.name);
    const VehicleConfig& vehicle = config_.vehicle;
    const bool cloud_known = is_placed(group.cloud_topic, vehicle.base_frame);
    std::set<std::string> unknown;
    std::size_t lost = 0;
    for (const std::string& frame : group.virtual_laser_scan) {
      if (is_placed(group.cloud_topic, frame)) continue;
      ++lost;
      if (!is_known(vehicle.base_frame, frame)) unknown.insert(frame);
      if (!cloud_known) unknown.insert(group.cloud_topic);
    }
    const bool on_vehicle = group.has_visibility() || !vehicle.footprint.empty() || vehicle.has_motion();
    if (on_vehicle && !cloud_known) unknown.insert(group.cloud_topic);
    tell_poses(entry, unknown, (on_vehicle && !cloud_known) || lost == group.virtual_laser_scan.size());
    tell_topics(entry, {group.cloud_topic});
  }

  const Config& config_;
  Value root_;
  NoTransforms no_tf_;
  FrameTree poses_;
  std::vector<std::string> sentences_;
};

/// Ports that the daemon listens on, and devices that it connects to, each with the sensors behind it.
TextTable sockets_of(const Config& config) {
  std::map<std::pair<std::string, std::string>, std::string> sensors;
  for (const SensorConfig& sensor : config.sensors) {
    for (const Flow& flow : flows_of(sensor)) {
      const bool listens = flow.transport == Transport::udp;
      if (!listens && sensor.driver.requests.listen_only) continue;
      const std::string port = std::to_string(flow.port);
      std::string& names =
          sensors[listens ? std::pair("listens", "udp " + port)
                          : std::pair("connects", "tcp " + flow.address.to_string() + ":" + port)];
      names += (names.empty() ? "" : ", ") + sensor.name;
    }
  }
  TextTable table{{"DOES", "SOCKET", "FOR"}};
  for (const auto& [socket, names] : sensors) table.push_back({socket.first, socket.second, names});
  // roscpp: topics and calls over TCP; it opens the port of UDPROS unasked. The kernel chooses all of them.
  table.push_back({"listens", "tcp, two free ports", "ROS"});
  table.push_back({"listens", "udp, one free port", "ROS"});
  table.push_back({"connects", "tcp, the ROS master's port", "ROS"});
  return table;
}

}  // namespace

int run_check_ports(const std::string& file, std::ostream& out, std::ostream& err) {
  return guarded(err, [&] {
    print_columns(sockets_of(load_config(file)), out);
    return exit_ok;
  });
}

int run_check(const std::string& file, std::ostream& out, std::ostream& err) {
  return guarded(err, [&] {
    const std::string text = read_file(file, "a readable YAML file");
    const Config config = parse_config(text, file);
    for (const std::string& warning : config.warnings) err << warning << '\n';
    for (const std::string& sentence : Forecast(config, text).all()) err << sentence << '\n';
    out << to_yaml(config);
    return exit_ok;
  });
}

}  // namespace lidard
