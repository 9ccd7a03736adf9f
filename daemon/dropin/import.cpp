// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/import.h"

#include <algorithm>
#include <map>
#include <ostream>
#include <set>

#include "core/base/number_text.h"
#include "daemon/config/config.h"
#include "daemon/config/key_tables.h"
#include "daemon/config/reading.h"
#include "daemon/files/text_file.h"

namespace lidard {
namespace {

void erase_key(KeyMap& map, std::string_view key) {
  map.erase(std::remove_if(map.begin(), map.end(), [&](const auto& one) { return one.first == key; }),
            map.end());
}

std::string text_of(KeyMap& map, std::string_view key) {
  const KeyValue* const value = find_key(map, key);
  const auto* const text = value == nullptr ? nullptr : std::get_if<std::string>(value);
  return text == nullptr ? std::string() : *text;
}

KeyMap& section(KeyMap& keys, const std::string& name) {
  if (find_key(keys, name) == nullptr) keys.emplace_back(name, KeyMap());
  return std::get<KeyMap>(*find_key(keys, name));
}

/// The package of the node, or for a parameter file the one with most of the parameters. Empty: unknown.
std::string_view package_name(const LaunchNode& node) {
  if (node.package.empty()) {
    const MovedPackage* const package = package_of(node.parameters);
    return package == nullptr ? std::string_view() : package->name;
  }
  for (const MovedPackage& package : moved_packages()) {
    const auto names = split_words(package.packages);
    if (std::find(names.begin(), names.end(), node.package) != names.end()) return package.name;
  }
  return {};
}

/// The tables of velodyne_pointcloud/params (1.7.0) that equal those of the models here: clouds differ by at
/// most 0.07 mm, from the rounding of angles in VLP16_hires_db.yaml.
bool is_table_of_model(const std::string& path) {
  if (path.find("velodyne_pointcloud/params/") == std::string::npos) return false;  // perhaps another table
  constexpr std::string_view names[] = {"VLP16db.yaml", "VLP16_hires_db.yaml", "32db.yaml",
                                        "VeloView-VLP-32C.yaml", "VLS128.yaml"};
  return std::find(std::begin(names), std::end(names), path.substr(path.rfind('/') + 1)) != std::end(names);
}

class Importer {
 public:
  explicit Importer(const LaunchFile& launch) : launch_(launch) { config_.remarks = launch.remarks; }

  ImportedConfig run() {
    std::vector<const LaunchNode*> late;
    for (const LaunchNode& node : launch_.nodes) {
      attempt(node, [&] {
        if (!import_node(node)) late.push_back(&node);
      });
    }
    // Nodes that merge are imported after their sources.
    for (const LaunchNode* node : late) attempt(*node, [&] { add_laser_tools(*node); });
    place();
    return std::move(config_);
  }

 private:
  /// Reports a node that cannot be imported; the others are imported.
  template <class Step>
  void attempt(const LaunchNode& node, const Step& step) {
    try {
      step();
    } catch (const ConfigError& trouble) {
      config_.changes.push_back(node.name + " was not imported: " + trouble.what());
    }
  }

  /// False for a node that reads topics of other nodes.
  bool import_node(const LaunchNode& node) {
    const std::string_view package = package_name(node);
    if (package == "ira_laser_tools") return false;
    const bool is_caller = node.type.empty() || node.type.find("sick_") == 0;
    if (package == "sick_safetyscanners") {
      add_sensor(node, safety_scanners_setup(node.parameters));
    } else if (package == "urg_node") {
      add_sensor(node, urg_node_setup(node.parameters));
    } else if (package == "sick_scan_xd" && is_caller) {
      add_sensor(node, sick_scan_setup(node.parameters));
    } else if (package == "ros-drivers/velodyne") {
      add_velodyne(node);
    } else if (node.type == "static_transform_publisher") {
      add_transform(node);
    } else if (node.package == "lidard") {
      config_.remarks.push_back(node.name + " is lidard with a configuration of its own, which stays");
    } else if (node.package != "nodelet") {
      config_.remarks.push_back(node.name + " (" + node.package + "/" + node.type +
                                ") is no node of a lidar that is known here; it stays in a launch file");
    }
    return true;
  }

  void remark(const LaunchNode& node, const DropinSetup& setup) {
    for (const auto& text : setup.warnings) config_.changes.push_back(node.name + ": " + text);
    for (const auto& text : setup.remarks) config_.remarks.push_back(node.name + ": " + text);
  }

  std::string free_name(const LaunchNode& node, const char* end = "") {
    const std::string name = entry_name(node.name.substr(node.name.rfind('/') + 1)) + end;
    std::string unique = name;
    for (int n = 2; !names_.insert(unique).second; ++n) unique = name + "_" + std::to_string(n);
    return unique;
  }

  void add_sensor(const LaunchNode& node, DropinSetup setup) {
    remark(node, setup);
    transforms_.insert(transforms_.end(), setup.transforms.begin(), setup.transforms.end());
    for (auto& [name, value] : section(setup.keys, "sensors")) {
      auto& sensor = std::get<KeyMap>(value);
      for (const char* key : {"scan_topic", "points_topic", "packet_topic", "raw_topic",
                              "extended_scan_topic", "output_paths_topic"}) {
        if (auto* topic = find_key(sensor, key); topic != nullptr)
          *topic = node.resolved(text_of(sensor, key));
      }
      drop_shared_topics(node, sensor);
      section(config_.keys, "sensors").emplace_back(free_name(node), std::move(sensor));
      ++config_.entries;
    }
    const std::string source = section(config_.keys, "sensors").back().first;
    for (auto& cloud : section(setup.keys, "merged_scans"))
      add_cloud(node, source, std::get<KeyMap>(cloud.second));
  }

  /// Adds the cloud of a planar scanner as a merged scan with one source.
  void add_cloud(const LaunchNode& node, const std::string& source, KeyMap& entry) {
    *find_key(entry, "laserscan_topics") = KeyList{source};
    *find_key(entry, "cloud_destination_topic") = node.resolved(text_of(entry, "cloud_destination_topic"));
    drop_shared_topics(node, entry);
    if (find_key(entry, "cloud_destination_topic") == nullptr) return;
    section(config_.keys, "merged_scans").emplace_back(free_name(node, "_cloud"), std::move(entry));
    ++config_.entries;
  }

  /// Two nodes may publish on one topic, two sensors may not: only the first sensor keeps a shared topic
  /// beside the scan.
  void drop_shared_topics(const LaunchNode& node, KeyMap& entry) {
    for (const char* key :
         {"raw_topic", "extended_scan_topic", "output_paths_topic", "cloud_destination_topic"}) {
      const std::string topic = text_of(entry, key);
      if (topic.empty() || side_topics_.insert(topic).second) continue;
      erase_key(entry, key);
      config_.changes.push_back(node.name + ": " + key + " was left out, since another node publishes on " +
                                topic + " too; name a topic of its own");
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
    if (node.package == "velodyne_laserscan" || (node.package == "velodyne_pointcloud" && has_driver)) return;
    NodeParameters parameters = node.parameters;
    if (node.package == "velodyne_pointcloud") parameters.emplace("packet_topic", "velodyne_packets");
    const LaunchNode* const points =
        node.package == "velodyne_driver" ? partner("velodyne_pointcloud", node, "velodyne_packets") : &node;
    const LaunchNode* const scan =
        partner("velodyne_laserscan", points == nullptr ? node : *points, "velodyne_points");
    for (const LaunchNode* const other : {points, scan}) {
      if (other != nullptr) parameters.insert(other->parameters.begin(), other->parameters.end());
    }
    DropinSetup setup = velodyne_node_setup(parameters);
    auto& sensor = std::get<KeyMap>(section(setup.keys, "sensors").front().second);
    if (scan == nullptr && !node.package.empty() && node.package != "velodyne_node") {
      for (const char* key : {"scan_ring", "scan_resolution", "scan_topic"}) erase_key(sensor, key);
    }
    if (const auto file = text_of(sensor, "calibration"); is_table_of_model(file)) {
      erase_key(sensor, "calibration");
      setup.remarks.push_back("parameter ~calibration (" + file +
                              ") is the table that the model has here too");
    }
    for (const auto& capture : setup.replay.captures)
      setup.warnings.push_back("parameter ~pcap: `lidard replay -c THIS --pcap " + capture + "` plays it");
    add_odometry(node, setup);
    add_sensor(node, std::move(setup));
  }

  /// Sets the odometry frame; a vehicle has only one.
  void add_odometry(const LaunchNode& node, DropinSetup& setup) {
    auto& vehicle = section(setup.keys, "vehicle");
    const std::string frame = text_of(vehicle, "odometry_frame");
    if (frame.empty()) return;
    if (odometry_.empty()) odometry_ = frame, moved_ = text_of(vehicle, "base_frame");
    if (odometry_ != frame)
      config_.changes.push_back(node.name + ": parameter ~fixed_frame (" + frame +
                                ") has no effect: clouds are deskewed in " + odometry_ +
                                ", the fixed_frame of another node");
  }

  /// x y z yaw pitch roll, or x y z qx qy qz qw; parent child [period].
  void add_transform(const LaunchNode& node) {
    std::vector<double> numbers;
    std::vector<std::string> frames;
    for (const auto& word : node.arguments) {
      const auto number = number_in<double>(word);
      if (number && frames.empty())
        numbers.push_back(*number);
      else
        frames.push_back(word.front() == '/' ? word.substr(1) : word);
    }
    if ((numbers.size() != 6 && numbers.size() != 7) || frames.size() < 2) {
      config_.changes.push_back(node.name + ": arguments that make no transform; it stays in a launch file");
      return;
    }
    Pose pose = make_pose({numbers[0], numbers[1], numbers[2]}, {numbers[5], numbers[4], numbers[3]});
    if (numbers.size() == 7) {
      const Eigen::Quaterniond turn(numbers[6], numbers[3], numbers[4], numbers[5]);
      pose.linear() = turn.normalized().toRotationMatrix();
    }
    // Before those that drivers publish if nobody forbids it: a frame has one parent.
    transforms_.insert(transforms_.begin(), {frames[0], frames[1], pose});
  }

  /// The sensor that publishes the topic; empty: none.
  std::string publisher_of(const std::string& topic) {
    for (auto& [name, value] : section(config_.keys, "sensors")) {
      auto& sensor = std::get<KeyMap>(value);
      if (text_of(sensor, "scan_topic") == topic || text_of(sensor, "points_topic") == topic ||
          text_of(sensor, "topic") == topic)
        return name;
    }
    return {};
  }

  void add_laser_tools(const LaunchNode& node) {
    const bool is_merger = node.type.find("merger") != std::string::npos ||
                           (node.type.empty() && node.parameters.count("virtual_laser_scan") == 0);
    DropinSetup setup =
        is_merger ? laser_merger_setup(node.parameters) : laser_virtualizer_setup(node.parameters);
    remark(node, setup);
    if (base_.empty()) base_ = text_of(section(setup.keys, "vehicle"), "base_frame");
    KeyList sources;
    for (auto& [name, value] : section(setup.keys, "sensors")) {
      const std::string topic = node.resolved(text_of(std::get<KeyMap>(value), "topic"));
      std::string source = publisher_of(topic);
      if (source.empty()) {
        source = names_.insert(name).second ? name : free_name(node);
        section(config_.keys, "sensors").emplace_back(source, KeyMap{{"topic", topic}});
        ++config_.entries;
      }
      sources.emplace_back(source);
    }
    const char* const kind = is_merger ? "merged_scans" : "virtual_scans";
    auto& entry = std::get<KeyMap>(section(setup.keys, kind).front().second);
    for (const char* key : {"scan_destination_topic", "cloud_destination_topic", "output_laser_topic"}) {
      if (const auto topic = text_of(entry, key); !topic.empty())
        *find_key(entry, key) = node.resolved(topic);
    }
    if (is_merger)
      *find_key(entry, "laserscan_topics") = sources;
    else
      *find_key(entry, "cloud_topic") = sources.front();
    section(config_.keys, kind).emplace_back(free_name(node), std::move(entry));
    ++config_.entries;
  }

  /// The pose of the frame in the base frame, through a chain of transforms.
  std::optional<Pose> pose_of(std::string frame, std::string& root) {
    Pose pose = Pose::Identity();
    std::set<const StaticTransform*> chain;
    root = frame;
    for (std::size_t steps = 0; steps <= transforms_.size() && frame != base_; ++steps) {
      const auto up = std::find_if(transforms_.begin(), transforms_.end(),
                                   [&](const StaticTransform& one) { return one.child == frame; });
      if (up == transforms_.end()) return std::nullopt;
      pose = up->pose * pose;
      chain.insert(&*up);
      root = frame = up->parent;
    }
    if (frame != base_) return std::nullopt;
    used_.merge(chain);
    return pose;
  }

  /// Throws ConfigError where a frame hangs from itself: then nothing has a root.
  void refuse_loops() const {
    for (const StaticTransform& begin : transforms_) {
      std::string chain = begin.child;
      const StaticTransform* up = &begin;
      for (std::size_t steps = 0; steps < transforms_.size(); ++steps) {
        chain += " in " + up->parent;
        if (up->parent == begin.child)
          throw ConfigError("the static transforms form a loop: " + chain +
                            "; expected one parent per frame");
        const auto next = std::find_if(transforms_.begin(), transforms_.end(),
                                       [&](const StaticTransform& one) { return one.child == up->parent; });
        if (next == transforms_.end()) break;
        up = &*next;
      }
    }
  }

  void place() {
    refuse_loops();
    if (!base_.empty() && base_.front() == '/') base_.erase(0, 1);
    auto& sensors = section(config_.keys, "sensors");
    std::string root;
    for (auto& [name, value] : sensors) {
      const std::string frame = without_slash(text_of(std::get<KeyMap>(value), "frame_id"));
      if (base_.empty() && !pose_of(frame, root) && root != frame && root != odometry_) base_ = root;
    }
    if (base_.empty()) base_ = without_slash(moved_);
    for (auto& [name, value] : sensors) {
      auto& sensor = std::get<KeyMap>(value);
      const std::string frame = without_slash(text_of(sensor, "frame_id"));
      if (frame.empty() || frame == base_) continue;
      if (const auto pose = pose_of(frame, root)) sensor.emplace_back("pose", *pose);
    }
    for (auto& [name, value] : section(config_.keys, "virtual_scans")) place_planes(std::get<KeyMap>(value));
    report_unused_transforms();
    if (!base_.empty()) section(config_.keys, "vehicle").emplace_back("base_frame", base_);
    if (!odometry_.empty()) section(config_.keys, "vehicle").emplace_back("odometry_frame", odometry_);
  }

  /// Transforms that no sensor and no virtual scan hangs from.
  void report_unused_transforms() {
    std::map<std::string, std::string> owners;
    for (auto& [name, sensor] : section(config_.keys, "sensors"))
      owners.emplace(without_slash(text_of(std::get<KeyMap>(sensor), "frame_id")), "sensors." + name + ": ");
    for (const StaticTransform& one : transforms_) {
      if (used_.count(&one) > 0) continue;
      const auto owner = owners.find(one.child);
      (owner != owners.end() ? config_.changes : config_.remarks)
          .push_back((owner != owners.end() ? owner->second : "") + "the pose of " + one.child + " in " +
                     one.parent + " is not part of this configuration, whose base_frame is " + base_ +
                     ": publish it on tf, " + yaml_text({{"pose", one.pose}}));
    }
  }

  void place_planes(KeyMap& entry) {
    KeyMap poses;
    std::string root;
    for (const KeyValue& frame : std::get<KeyList>(*find_key(entry, "virtual_laser_scan"))) {
      const std::string name = without_slash(std::get<std::string>(frame));
      if (const auto pose = pose_of(name, root)) poses.emplace_back(name, *pose);
    }
    if (!poses.empty()) entry.emplace_back("poses", poses);
  }

  const LaunchFile& launch_;
  ImportedConfig config_;
  std::set<std::string> names_, side_topics_;
  std::vector<StaticTransform> transforms_;
  std::set<const StaticTransform*> used_;  // parts of a pose
  std::string base_;
  std::string odometry_, moved_;  // the fixed frame, and the frame of a sensor that moves in it
};

std::string file_text(const std::string& file, const ImportedConfig& config) {
  KeyMap filled;
  for (const char* name : {"vehicle", "sensors", "merged_scans", "virtual_scans"}) {
    for (const auto& [section_name, value] : config.keys) {
      if (section_name == name && !std::get<KeyMap>(value).empty()) filled.emplace_back(section_name, value);
    }
  }
  std::string text =
      "# Made by `lidard import " + file.substr(file.rfind('/') + 1) + "`.\n" + yaml_text(filled);
  const auto add = [&text](const char* title, const std::vector<std::string>& list) {
    text += list.empty() ? "" : title;
    for (std::string remark : list) {
      std::replace(remark.begin(), remark.end(), '\n', ' ');
      text += "# - " + remark + "\n";
    }
  };
  add("\n# What changes for the robot:\n", config.changes);
  add("\n# What is no longer needed, or stays as it is:\n", config.remarks);
  return text;
}

int import_file(const ImportOptions& options, std::ostream& err) {
  const ImportedConfig config = import_nodes(read_launch(options.file, options.arguments));
  if (config.entries == 0) {
    for (const auto* list : {&config.changes, &config.remarks}) {
      for (const auto& remark : *list) err << remark << '\n';
    }
    err << options.file << ": nothing in it can be imported; expected a node of";
    for (const MovedPackage& package : moved_packages())
      err << (&package == &moved_packages().front() ? " " : ", ") << package.name;
    err << '\n';
    return exit_failed;
  }
  const std::string text = file_text(options.file, config);
  TextFile file(options.output);
  file.write(text);
  file.close();
  parse_config(text, options.output == "-" ? "the configuration" : options.output);
  err << config.entries << (config.entries == 1 ? " entry" : " entries") << "; below the configuration "
      << config.changes.size() << " on what changes for the robot, " << config.remarks.size()
      << " on what is no longer needed\n";
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
