// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/import.h"

#include <algorithm>
#include <map>
#include <ostream>
#include <set>

#include "daemon/config/config.h"
#include "daemon/config/values.h"
#include "daemon/dropin/import_poses.h"
#include "daemon/files/text_file.h"

namespace lidard {
namespace {

constexpr const char* serial =
    "lidard reads no serial port (there is no ~ip_address); it stays in a launch file, "
    "`topic` reads its scan";

/// The package of the node, by the name in the launch file or by that of the executable, as of a fork. Empty
/// for other executables of the package too.
std::string_view package_name(const LaunchNode& node) {
  for (const std::string& given : {node.package, node.type}) {
    for (const MovedPackage& package : moved_packages()) {
      const auto names = split_words(package.packages), types = split_words(package.types);
      if (given.empty() || std::find(names.begin(), names.end(), given) == names.end()) continue;
      const bool is_known = node.type.empty() || package.types == "*" ||
                            std::any_of(types.begin(), types.end(), [&](const std::string& part) {
                              return node.type.find(part) != std::string::npos;
                            });
      return is_known ? package.name : std::string_view();
    }
  }
  return {};
}

/// Nodes that read topics of other nodes are imported after these: those that filter, those that cut, those
/// that merge. 0: a node that reads no topic.
int stage_of(const LaunchNode& node) {
  const std::string_view package = package_name(node);
  if (package == "laser_filters") return 1;
  if (package == "pointcloud_to_laserscan") return 2;
  return package == "ira_laser_tools" || package == "cob_scan_unifier" ? 3 : 0;
}

constexpr std::string_view input_topic = "packet_topic";  // the others are of outputs
constexpr std::string_view topic_keys[] = {input_topic,
                                           "scan_topic",
                                           "points_topic",
                                           "raw_topic",
                                           "extended_scan_topic",
                                           "output_paths_topic",
                                           "cloud_destination_topic",
                                           "scan_destination_topic",
                                           "output_laser_topic"};

/// The tables of velodyne_pointcloud/params (1.7.0) that equal those of the models here: clouds differ by at
/// most 0.07 mm, from the rounding of angles in VLP16_hires_db.yaml. A folder elsewhere may hold another
/// table.
bool is_table_of(const std::string& model, const std::string& path) {
  static const std::map<std::string, std::string> tables{{"VLP16db.yaml", "velodyne_vlp16"},
                                                         {"VLP16_hires_db.yaml", "velodyne_puck_hires"},
                                                         {"32db.yaml", "velodyne_hdl32e"},
                                                         {"VeloView-VLP-32C.yaml", "velodyne_vlp32c"},
                                                         {"VLS128.yaml", "velodyne_vls128"}};
  const std::size_t name = path.rfind('/') + 1;
  const auto found = tables.find(path.substr(name));
  const bool is_theirs = name == 0 || path.find("velodyne_pointcloud/params/") != std::string::npos;
  return is_theirs && found != tables.end() && found->second == model;
}

class Importer {
 public:
  explicit Importer(LaunchFile launch) : launch_(std::move(launch)) {
    config_.changes = launch_.changes;
    config_.remarks = launch_.remarks;
    for (LaunchNode& node : launch_.nodes) identify(node);
  }

  ImportedConfig run() {
    for (const int stage : {0, 1, 2, 3}) {
      for (const LaunchNode& node : launch_.nodes) {
        if (stage_of(node) == stage) attempt(node, stage == 0 ? &Importer::import_node : &Importer::add_tool);
      }
    }
    poses_.apply(config_);
    auto& vehicle = config_.keys.vehicle;
    for (auto& [frame, box] : boxes_) {
      const bool is_vehicle = frame == text_of(vehicle, "base_frame");
      if (is_vehicle) vehicle.emplace_back("footprint", box);
      config_.changes.push_back("LaserScanBoxFilter in " + frame +
                                (is_vehicle
                                     ? " became vehicle.footprint, at all heights and for all merged scans"
                                     : " was left out; vehicle.footprint removes the vehicle"));
    }
    return std::move(config_);
  }

 private:
  /// Reports a node that cannot be imported; the others are imported.
  void attempt(const LaunchNode& node, void (Importer::*import)(const LaunchNode&)) {
    try {
      (this->*import)(node);
    } catch (const ConfigError& trouble) {
      config_.changes.push_back(node.name + " was not imported: " + trouble.what());
    }
  }

  /// Names the package of a node of a parameter file.
  void identify(LaunchNode& node) {
    if (!node.package.empty() || !node.type.empty()) return;
    std::string word;
    const MovedPackage* const package = package_of(node.name, node.parameters, word);
    if (package == nullptr)
      config_.stays.push_back(node.name + ": its parameters are not those of one driver that is known here");
    else
      node.package = word.empty() ? split_words(package->packages).back() : word;
    if (word == "velodyne_transform" || word == "velodyne_convert") node.package = "velodyne_pointcloud";
  }

  void import_node(const LaunchNode& node) {
    const std::string_view package = package_name(node);
    if (package == "sick_safetyscanners") {
      add_sensor(node, safety_scanners_setup(node.parameters));
    } else if (package == "urg_node") {
      if (!has_value(node, "ip_address") && !has_value(node, "laser_ip_address")) throw ConfigError(serial);
      add_sensor(node, urg_node_setup(node.parameters));
    } else if (package == "sick_scan_xd") {
      add_sensor(node, sick_scan_setup(node.parameters));
    } else if (package == "LMS1xx") {
      add_sensor(node, lms1xx_setup(node.parameters));
    } else if (package == "sick_tim") {
      add_sensor(node, sick_tim_setup(node.type.empty() ? node.package : node.type, node.parameters));
    } else if (package == "nebula") {
      add_sensor(node, nebula_setup(node.parameters));
    } else if (package == "ros-drivers/velodyne") {
      add_velodyne(node);
    } else if (node.type == "static_transform_publisher") {
      if (!poses_.add_publisher(node))
        config_.changes.push_back(node.name +
                                  ": arguments that make no transform; it stays in a launch file");
    } else if (node.package == "hokuyo_node") {
      throw ConfigError(serial);
    } else if (node.package == "lidard") {
      config_.stays.push_back(node.name + " is lidard with a configuration of its own");
    } else if (node.package != "nodelet" && !node.package.empty()) {
      config_.stays.push_back(node.name + " (" + node.package + "/" + node.type +
                              ") is no node of a lidar that is known here; it stays in a launch file");
    }
  }

  static bool has_value(const LaunchNode& node, const char* name) {
    const auto found = node.parameters.find(name);
    return found != node.parameters.end() && !found->second.empty();
  }

  void remark(const LaunchNode& node, const DropinSetup& setup) {
    for (const auto& text : setup.warnings) config_.changes.push_back(node.name + ": " + text);
    for (const auto& text : setup.remarks) config_.remarks.push_back(node.name + ": " + text);
  }

  std::string free_name(const LaunchNode& node, const char* end = "") {
    return unique_name(entry_name(node.name.substr(node.name.rfind('/') + 1)) + end, names_);
  }

  void add_sensor(const LaunchNode& node, DropinSetup setup) {
    remark(node, setup);
    for (const StaticTransform& one : setup.transforms) poses_.add_driver(node, one);
    auto& [name, sensor] = setup.keys.sensors.front();
    resolve_topics(node, sensor);
    drop_shared_topics(node, sensor);
    name = free_name(node);
    for (auto& cloud : setup.keys.merged_scans) add_cloud(node, name, cloud.second);
    config_.keys.sensors.push_back(std::move(setup.keys.sensors.front()));
  }

  /// Adds the cloud of a planar scanner as a merged scan with one source.
  void add_cloud(const LaunchNode& node, const std::string& source, KeyMap& entry) {
    *find_key(entry, "laserscan_topics") = KeyList{source};
    resolve_topics(node, entry);
    drop_shared_topics(node, entry);
    if (find_key(entry, "cloud_destination_topic") == nullptr) return;
    config_.keys.merged_scans.emplace_back(free_name(node, "_cloud"), std::move(entry));
  }

  static void resolve_topics(const LaunchNode& node, KeyMap& entry) {
    for (const std::string_view key : topic_keys) {
      if (const std::string topic = text_of(entry, key); !topic.empty())
        *find_key(entry, key) = node.resolved(topic);
    }
  }

  /// Two nodes may publish on one topic, two sensors may not: only the first sensor keeps a shared topic.
  void drop_shared_topics(const LaunchNode& node, KeyMap& entry) {
    for (const std::string_view key : topic_keys) {
      const std::string topic = text_of(entry, key);
      if (topic.empty() || key == input_topic || topics_.insert(topic).second) continue;
      erase_key(entry, key);
      config_.changes.push_back(node.name + ": " + std::string(key) +
                                " was left out, since another node publishes on " + topic +
                                " too; name a topic of its own");
    }
  }

  /// The node of the package that shares a topic with another node.
  const LaunchNode* partner(const char* package, const LaunchNode& other, const char* topic) const {
    for (const LaunchNode& node : launch_.nodes) {
      if (node.package == package && node.resolved(topic) == other.resolved(topic)) return &node;
    }
    return nullptr;
  }

  /// Combines the driver, the transformation and the scan of a Velodyne to one sensor.
  void add_velodyne(const LaunchNode& node) {
    const bool has_driver = partner("velodyne_driver", node, "velodyne_packets") != nullptr;
    const bool is_alone = node.package == "velodyne_laserscan"
                              ? partner("velodyne_pointcloud", node, "velodyne_points") == nullptr
                              : !has_driver && !has_value(node, "model");
    if (is_alone) throw ConfigError("the file has no driver of this Velodyne; expected one, or ~model");
    if (node.package == "velodyne_laserscan" || (node.package == "velodyne_pointcloud" && has_driver)) return;
    NodeParameters parameters = node.parameters;
    const bool is_fed = node.package == "velodyne_pointcloud";
    if (is_fed) parameters.emplace("packet_topic", "velodyne_packets");
    const LaunchNode* const points =
        node.package == "velodyne_driver" ? partner("velodyne_pointcloud", node, "velodyne_packets") : &node;
    const LaunchNode* const scan =
        partner("velodyne_laserscan", points == nullptr ? node : *points, "velodyne_points");
    for (const LaunchNode* const other : {points, scan}) {
      if (other != nullptr) parameters.insert(other->parameters.begin(), other->parameters.end());
    }
    DropinSetup setup = velodyne_node_setup(parameters);
    if (is_fed)
      setup.warnings.emplace_back("packets come from packet_topic: the file has no driver of the Velodyne");
    auto& sensor = setup.keys.sensors.front().second;
    if (scan == nullptr && !node.package.empty() && node.package != "velodyne_node") {
      for (const char* key : {"scan_ring", "scan_resolution", "scan_topic"}) erase_key(sensor, key);
    }
    if (const auto file = text_of(sensor, "calibration"); is_table_of(text_of(sensor, "model"), file)) {
      erase_key(sensor, "calibration");
      setup.remarks.push_back("parameter ~calibration (" + file +
                              ") is the table that the model has here too");
    }
    for (const auto& capture : setup.replay.captures)
      setup.warnings.push_back("parameter ~pcap: `lidard replay -c THIS --pcap " + capture + "` plays it");
    auto& vehicle = setup.keys.vehicle;
    const std::string fixed = text_of(vehicle, "odometry_frame");
    if (const auto set = poses_.set_odometry(fixed, text_of(vehicle, "base_frame"));
        set != fixed && !fixed.empty())
      setup.warnings.push_back("parameter ~fixed_frame (" + fixed +
                               ") has no effect: clouds are deskewed in " + set +
                               ", the fixed_frame of another node");
    add_sensor(node, std::move(setup));
  }

  /// The sensor that publishes the topic, itself or through filters; nullptr: none.
  std::pair<std::string, KeyMap>* publisher_of(const std::string& topic) {
    const auto view = views_.find(topic);
    for (auto& one : config_.keys.sensors) {
      if (view != views_.end() && view->second.first == one.first) return &one;
      for (const char* key : {"scan_topic", "points_topic", "topic"}) {
        if (text_of(one.second, key) == topic) return &one;
      }
    }
    return nullptr;
  }

  /// The setup of a node that reads topics.
  DropinSetup tool_setup(const LaunchNode& node) {
    const std::string_view package = package_name(node);
    const bool is_filter = package == "laser_filters";
    if (is_filter || package == "pointcloud_to_laserscan") {
      auto* const source = publisher_of(node.resolved(is_filter ? "scan" : "cloud_in"));
      KeyMap sensor = source == nullptr ? KeyMap() : source->second;
      const std::string moved = text_of(sensor, "points_frame");
      const std::string frame = moved.empty() ? text_of(sensor, "frame_id") : moved;
      return is_filter ? scan_filters_setup(node.parameters, frame) : flat_scan_setup(node.parameters, frame);
    }
    if (package == "cob_scan_unifier") return scan_unifier_setup(node.parameters);
    const bool is_merger = node.type.find("merger") != std::string::npos ||
                           (node.type.empty() && node.parameters.count("virtual_laser_scan") == 0);
    return is_merger ? laser_merger_setup(node.parameters) : laser_virtualizer_setup(node.parameters);
  }

  void add_tool(const LaunchNode& node) {
    DropinSetup setup = tool_setup(node);
    remark(node, setup);
    auto& vehicle = setup.keys.vehicle;
    poses_.set_base(text_of(vehicle, "base_frame"));
    if (auto* const box = find_key(vehicle, "footprint")) boxes_[text_of(vehicle, "box_frame")] = *box;
    const bool is_merger = !setup.keys.merged_scans.empty();
    auto& entry = (is_merger ? setup.keys.merged_scans : setup.keys.virtual_scans).front().second;
    resolve_topics(node, entry);
    KeyList sources;
    KeyMap windows;
    for (auto& [name, sensor] : setup.keys.sensors) {
      const std::string topic = node.resolved(text_of(sensor, "topic"));
      const auto* const publisher = publisher_of(topic);
      const std::string source = publisher != nullptr         ? publisher->first
                                 : names_.insert(name).second ? name
                                                              : free_name(node);
      const bool is_output = publisher == nullptr && topics_.count(topic) > 0;
      if (is_output && (!is_merger || cuts_.count(topic) == 0))
        throw ConfigError("it reads " + topic + ", an output of a merged scan; it stays in a launch file");
      if (publisher == nullptr && !is_output) config_.keys.sensors.push_back({source, {{"topic", topic}}});
      sources.emplace_back(is_output ? topic : source);
      KeyMap window = views_[topic].second;
      if (auto* const own = find_key(entry, "window")) {
        window = std::get<KeyMap>(*own);
        views_[text_of(entry, "scan_destination_topic")] = {source, window};
      }
      if (!window.empty()) windows.emplace_back(source, window);
    }
    erase_key(entry, "window");
    *find_key(entry, is_merger ? "laserscan_topics" : "cloud_topic") =
        is_merger ? KeyValue(sources) : sources.front();
    if (!windows.empty()) entry.emplace_back("source_settings", windows);
    drop_shared_topics(node, entry);
    if (!is_merger) cuts_.insert(text_of(entry, "output_laser_topic"));
    (is_merger ? config_.keys.merged_scans : config_.keys.virtual_scans)
        .emplace_back(free_name(node), std::move(entry));
  }

  std::map<std::string, KeyValue> boxes_;  // corners by frames
  LaunchFile launch_;
  ImportedConfig config_;
  ImportPoses poses_;
  std::set<std::string> names_, topics_, cuts_;  // of entries, of all outputs, of virtual scans
  /// Filtered scans by their topics: the sensor, and the window that is left of it.
  std::map<std::string, std::pair<std::string, KeyMap>> views_;
};

std::string file_text(const std::string& file, const ImportedConfig& config) {
  std::string text =
      "# Made by `lidard import " + file.substr(file.rfind('/') + 1) + "`.\n" + config.keys.yaml();
  const auto add = [&text](const char* title, const std::vector<std::string>& list) {
    text += list.empty() ? "" : title;
    for (std::string remark : list) {
      std::replace(remark.begin(), remark.end(), '\n', ' ');
      text += "# - " + remark + "\n";
    }
  };
  add("\n# What changes for the robot:\n", config.changes);
  add("\n# What stays in a launch file:\n", config.stays);
  add("\n# What is no longer needed:\n", config.remarks);
  return text;
}

int import_file(const ImportOptions& options, std::ostream& err) {
  const ImportedConfig config = import_nodes(read_launch(options.file, options.arguments));
  const std::size_t entries = config.entries();
  if (entries == 0) {
    for (const auto* list : {&config.changes, &config.stays, &config.remarks}) {
      for (const auto& remark : *list) err << remark << '\n';
    }
    err << options.file << ": nothing in it can be imported; expected a node of";
    for (const MovedPackage& package : moved_packages())
      err << (&package == &moved_packages().front() ? " " : ", ") << package.name;
    err << '\n';
    return exit_failed;
  }
  const std::string text = file_text(options.file, config);
  parse_config(text, "the configuration");
  TextFile file(options.output);
  file.write(text);
  file.close();
  err << entries << (entries == 1 ? " entry" : " entries") << "; below the configuration "
      << config.changes.size() << " on what changes for the robot, " << config.stays.size()
      << " on what stays in a launch file, " << config.remarks.size() << " on what is no longer needed\n";
  return exit_ok;
}

}  // namespace

ImportedConfig import_nodes(const LaunchFile& launch) { return Importer(launch).run(); }

int run_import(const ImportOptions& options, std::ostream& out, std::ostream& err) {
  return guarded(err, [&]() -> int {
    if (!options.tables) return import_file(options, err);
    out << moved_markdown();
    return exit_ok;
  });
}

}  // namespace lidard
