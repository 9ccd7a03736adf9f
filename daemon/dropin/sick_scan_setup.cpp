// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "core/base/number_text.h"
#include "daemon/config/values.h"
#include "daemon/dropin/moving.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

/// sick_scan_xd's names of scanner types (include/sick_scan/sick_generic_parser.h).
const ModelNames scanner_types{{"sick_lms_1xx", "sick_lms1xx"},
                               {"sick_lms_1xxx", "sick_lms1000"},
                               {"sick_lms_4xxx", "sick_lms4000"},
                               {"sick_lms_5xx", "sick_lms5xx"},
                               {"sick_tim_240", "sick_tim240"},
                               {"sick_tim_4xx", "sick_tim4xx"},
                               {"sick_tim_5xx", "sick_tim5xx"},
                               {"sick_tim_7xx", "sick_tim7xx"},
                               {"sick_tim_7xxS", "sick_tim7xxs"},
                               {"sick_mrs_1xxx", "sick_mrs1000"},
                               {"sick_lrs_36x0", "sick_lrs36x0"},
                               {"sick_lrs_36x1", "sick_lrs36x1"},
                               {"sick_lrs_4xxx", "sick_lrs4000"},
                               {"sick_nav_2xx", "sick_nav2xx"},
                               {"sick_nav_31x", "sick_nav31x"},
                               {"sick_oem_15xx", "sick_oem15xx"},
                               {"sick_picoscan", "sick_picoscan150"},
                               {"sick_multiscan", "sick_multiscan136"},
                               {"sick_scansegment_xd", "sick_multiscan136"}};

/// "x,y,z,roll,pitch,yaw", m and rad.
Pose read_pose(Translation& node, const std::string& name) {
  const std::string given = node.text(name, "0,0,0,0,0,0");
  std::string text = given;
  std::replace(text.begin(), text.end(), ',', ' ');
  std::vector<double> numbers;
  for (const auto& word : split_words(text)) {
    const auto number = number_in<double>(word);
    if (number) numbers.push_back(*number);
  }
  if (numbers.size() != 6 || split_words(text).size() != 6)
    throw ConfigError("parameter ~" + name + " is '" + given + "'; expected six numbers");
  return make_pose({numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]});
}

/// Sets the sensor's pose from its frame on tf and from the transform of points by sick_scan_xd. If another
/// node publishes the frame, the sensor gets its own frame below it.
void add_pose(Translation& node, std::string& frame) {
  const std::string base = node.text("tf_base_frame_id", "map");
  const double rate = node.number("tf_publish_rate", 10);
  const Pose mounted = read_pose(node, "tf_base_lidar_xyz_rpy");
  const Pose moved = read_pose(node, "add_transform_xyz_rpy");
  const bool is_moved = !moved.isApprox(Pose::Identity());
  if (is_moved && rate <= 0) node.setup.transforms.push_back({frame, frame + "_device", moved});
  if (is_moved && rate <= 0) frame += "_device";
  if (is_moved)
    node.warn("parameter ~add_transform_xyz_rpy is part of the pose of " + frame +
              ": it moves the scan with the cloud, while sick_scan_xd moved the cloud alone");
  if (rate > 0) node.setup.transforms.push_back({base, frame, mounted * moved});
}

/// The topic of the first whole cloud in x, y and z of ~custom_pointclouds; reports those that are not
/// published.
std::string custom_cloud(Translation& node) {
  std::string first, others;
  for (const std::string& name : split_words(node.text("custom_pointclouds", ""))) {
    const std::string properties = " " + node.text(name, "") + " ";
    const auto has = [&](const char* one) { return properties.find(one) != std::string::npos; };
    if (has(" publish=0 ")) continue;
    const std::size_t at = properties.find(" topic=") + 7;
    const std::string topic = has(" topic=") ? properties.substr(at, properties.find(' ', at) - at) : name;
    const bool is_first = first.empty() && !has(" coordinateNotation=1 ") && !has(" updateMethod=1 ");
    (is_first ? first : others) += (is_first || others.empty() ? "" : ", ") + topic;
  }
  if (!others.empty())
    node.warn("clouds of ~custom_pointclouds that are not published: " + others +
              (first.empty() ? "" : "; all returns are on " + first));
  return first;
}

/// Drops a login with only one of its parameters: sick_scan_xd uses the device's default then.
void pair_login(KeyMap& sensor, Translation& node) {
  const auto is_login = [](const auto& one) { return one.first.compare(0, 10, "user_level") == 0; };
  if (std::count_if(sensor.begin(), sensor.end(), is_login) != 1) return;
  sensor.erase(std::remove_if(sensor.begin(), sensor.end(), is_login), sensor.end());
  node.warn("one of ~user_level and ~user_level_password alone was left out: both are needed");
}

bool accepts_key(const Model& model, std::string_view name) {
  SensorConfig any;
  const Keys keys = sensor_keys(any);
  return std::any_of(keys.begin(), keys.end(), [&](const Key& key) {
    return key.name == name && (!key.trait || model.has(*key.trait));
  });
}

/// Removes and reports keys that the sensor's model does not accept.
void drop_rejected(const Model& model, KeyMap& sensor, Translation& node) {
  const auto is_rejected = [&](const auto& one) {
    if (accepts_key(model, one.first)) return false;
    node.warn("key " + one.first + " was left out: a " + std::string(model.product) + " has no use for it");
    return true;
  };
  sensor.erase(std::remove_if(sensor.begin(), sensor.end(), is_rejected), sensor.end());
}

/// Parameters of a driver that came before sick_scan_xd, without the transforms and the cloud of the latter.
NodeParameters older_parameters(NodeParameters parameters, const char* scanner_type,
                                const char* port = "2112") {
  parameters["scanner_type"] = scanner_type;
  parameters["tf_publish_rate"] = "0";
  parameters.insert({{"port", port}, {"frame_id", "laser"}, {"cloud_topic", ""}});
  return parameters;
}

}  // namespace

DropinSetup sick_scan_setup(const NodeParameters& parameters) {
  Translation node(parameters);
  const Model& type = model_named(scanner_types, "scanner_type", node.text("scanner_type", ""));
  const bool is_165 = type.name == "sick_multiscan136" && node.text("layer_lookup_table_id", "0") == "1";
  const Model& model = is_165 ? *find_model("sick_multiscan165") : type;
  KeyMap sensor{{"model", std::string(model.name)}, {"ip_address", node.text("hostname", "192.168.0.1")}};
  const std::string port = node.text("port", "");
  if (model.name == "sick_lrs4000")
    node.setup.remarks.emplace_back(
        "port is not taken over: an LRS4000 is read from its port for measured data");
  else if (model.transport == Transport::tcp && !port.empty())
    sensor.emplace_back("ip_port", port);
  if (model.name == "sick_picoscan150")
    node.warn("model is to be changed for a picoScan120, which sick_scan_xd does not distinguish");
  std::string frame = without_slash(node.text("frame_id", node.text("publish_frame_id", "cloud")));
  if (frame.empty()) frame = "cloud";
  add_pose(node, frame);
  sensor.emplace_back("frame_id", frame);
  const std::string scan =
      node.text("publish_laserscan_fullframe_topic", node.text("laserscan_topic", "scan"));
  sensor.emplace_back("scan_topic", scan);
  const bool is_planar = model.kind == FrameKind::scan;
  // Clouds of a picoScan and a multiScan have topics of their own.
  const bool has_custom_clouds = model.transport != Transport::tcp;
  const std::string custom = has_custom_clouds ? custom_cloud(node) : "";
  const bool has_cloud = !is_planar || !has_custom_clouds;
  const std::string cloud = node.text("cloud_topic", custom.empty() && has_cloud ? "cloud" : custom);
  if (!is_planar) sensor.emplace_back("points_topic", cloud);
  node.move("sick_scan_xd", sensor);
  // sick_scan_xd writes the settings of the device.
  if (find_key(sensor, "listen_only") == nullptr) sensor.emplace_back("allow_write", true);
  pair_login(sensor, node);
  drop_rejected(model, sensor, node);
  node.setup.keys.sensors = {{"scanner", std::move(sensor)}};
  if (is_planar && !cloud.empty())
    node.setup.keys.merged_scans = {{"scanner_cloud",
                                     {{"laserscan_topics", KeyList{"scanner"}},
                                      {"destination_frame", frame},
                                      {"cloud_destination_topic", cloud}}}};
  return node.finish();
}

DropinSetup lms1xx_setup(const NodeParameters& parameters) {
  NodeParameters ours = older_parameters(parameters, "sick_lms_1xx", "2111");
  const auto host = ours.insert({"host", "192.168.1.2"}).first->second;
  ours["hostname"] = host;
  if (ours["publish_2nd_pulse"] == "true") ours["host_FREchoFilter"] = "1";
  for (const char* name : {"host", "publish_2nd_pulse", "publish_min_range_as_inf"}) ours.erase(name);
  DropinSetup setup = sick_scan_setup(ours);
  setup.warnings.emplace_back("a beam without return is +inf (theirs: 0.0)");
  return setup;
}

DropinSetup sick_tim_setup(const std::string& type, const NodeParameters& parameters) {
  const bool is_mrs = type.find("mrs1000") != std::string::npos;
  if ((!is_mrs && type.find("tim5") == std::string::npos) || parameters.count("hostname") == 0)
    throw ConfigError(type + " of sick_tim reads the scanner over USB here, which lidard does not; " +
                      "expected a scanner with Ethernet, its address in ~hostname");
  NodeParameters ours = parameters;
  if (is_mrs) ours.emplace("cloud_topic", "cloud");
  DropinSetup setup = sick_scan_setup(older_parameters(ours, is_mrs ? "sick_mrs_1xxx" : "sick_tim_5xx"));
  // sick_tim starts the scanner's stream and writes no settings.
  erase_key(setup.keys.sensors.front().second, "allow_write");
  return setup;
}

}  // namespace lidard
