// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "daemon/config/config.h"
#include "daemon/config/values.h"
#include "daemon/dropin/moving.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

/// The names of ros-drivers/velodyne.
const ModelNames driver_names{{"VLP16", "velodyne_vlp16"},         {"32C", "velodyne_vlp32c"},
                              {"32E", "velodyne_hdl32e"},          {"VLS128", "velodyne_vls128"},
                              {"64E", "velodyne_hdl64e_s1"},       {"64E_S2", "velodyne_hdl64e_s2"},
                              {"64E_S2.1", "velodyne_hdl64e_s21"}, {"64E_S3", "velodyne_hdl64e_s3"}};

const ModelNames nebula_names{
    {"VLP16", "velodyne_vlp16"}, {"VLP32", "velodyne_vlp32c"}, {"VLS128", "velodyne_vls128"}};

const Model& model_of(const std::string& given, const std::string& calibration) {
  const std::string file = calibration.substr(calibration.rfind('/') + 1);
  // velodyne_driver has no Puck Hi-Res: its users set a VLP-16 with another calibration.
  if (given == "VLP16" && file.find("hires") != std::string::npos) return *find_model("velodyne_puck_hires");
  return model_named(driver_names, "model", given);
}

/// Adds the parameters of velodyne_driver, except those of captures.
void add_driver(Translation& node, const Model& model, bool live, KeyMap& sensor) {
  sensor.emplace_back("model", std::string(model.name));
  const std::string address = node.text("device_ip", "");
  const double port = node.number("port", 2368);
  const std::string packets = node.text("packet_topic", "");
  // As the driver; packets from a topic are published already.
  if (node.flag("publish_packets", packets.empty() ? "true" : "false"))
    sensor.emplace_back("raw_topic", "velodyne_packets");
  if (!packets.empty()) {
    sensor.emplace_back("packet_topic", packets);
  } else {
    if (!address.empty()) sensor.emplace_back("ip_address", address);
    sensor.emplace_back("ip_port", port);
    // Several of these nodes may run on one machine, and the original nodes do not listen there either.
    const double telemetry = node.number("telemetry_port", live ? 0 : model.telemetry_port);
    if (model.telemetry_port != 0) sensor.emplace_back("telemetry_port", telemetry);
  }
  sensor.emplace_back("time_offset", node.number("time_offset", 0));
  sensor.emplace_back("frame_stamp", node.flag("timestamp_first_packet") ? "first" : "last");
  // By default the cut is behind, where scans go from +pi to -pi.
  const double cut = node.number("cut_angle", -0.01);
  sensor.emplace_back("cut_angle", cut < 0 ? pi_d : cut);
}

/// Adds the parameters of velodyne_pointcloud and velodyne_laserscan.
void add_outputs(Translation& node, const Model& model, const std::string& calibration, KeyMap& sensor) {
  constexpr std::pair<const char*, double> plain[] = {
      {"min_range", 0.9}, {"max_range", 130}, {"view_direction", 0}};
  for (const auto& [name, preset] : plain) sensor.emplace_back(name, node.number(name, preset));
  // As in the original, 0 is the whole turn, and a ring beyond the last one is the default.
  const double view = node.number("view_width", two_pi);
  sensor.emplace_back("view_width", view > 0 ? std::min(view, two_pi) : two_pi);
  sensor.emplace_back("organize_cloud", node.flag("organize_cloud") ? "firings" : "false");
  const bool has_table = model.name.find("hdl64e") == std::string::npos;
  if (!calibration.empty()) sensor.emplace_back("calibration", calibration);
  if (!calibration.empty() || has_table) sensor.emplace_back("calibration_model", "ros_drivers");
  const double ring = node.number("laserscan_ring", node.number("ring", -1));
  const auto rings = static_cast<double>(model.beams);
  sensor.emplace_back("scan_ring",
                      ring < 0 || ring >= rings ? KeyValue(std::string("auto")) : KeyValue(ring));
  sensor.emplace_back("scan_resolution",
                      node.number("laserscan_resolution", node.number("resolution", 0.007)));
  sensor.emplace_back("points_topic", "velodyne_points");
  sensor.emplace_back("scan_topic", "scan");
}

/// Adds the frame of clouds and the fixed frame; returns the section `vehicle`.
KeyMap add_frames(Translation& node, const std::string& own, KeyMap& sensor) {
  const std::string fixed = without_slash(node.text("fixed_frame", ""));
  const std::string target = without_slash(node.text("target_frame", ""));
  sensor.emplace_back("frame_id", own);
  if (!(target + fixed).empty()) sensor.emplace_back("points_frame", target.empty() ? fixed : target);
  if (fixed.empty() || fixed == without_slash(own)) return {};
  sensor.emplace_back("deskew", true);
  // The motion of the sensor itself is used, so no other frame of the vehicle is needed.
  return {{"base_frame", own}, {"odometry_frame", fixed}};
}

void read_replay(Translation& node, ReplayOptions& replay) {
  const std::string capture = node.text("pcap", "");
  const bool fast = node.flag("read_fast");
  const bool once = node.flag("read_once");
  const double delay = node.number("repeat_delay", 0);
  const bool capture_time = node.flag("pcap_time");
  if (capture.empty()) return;
  replay.captures = {capture};
  replay.rate = fast ? 0 : 1;
  replay.loop = !once;
  replay.loop_gap = span_from_seconds(std::clamp(delay, 0.001, 86400.0));
  replay.restamp = !capture_time;
}

}  // namespace

DropinSetup velodyne_node_setup(const NodeParameters& parameters) {
  Translation node(parameters);
  read_replay(node, node.setup.replay);
  const std::string calibration = node.text("calibration", "");
  const Model& model = model_of(node.text("model", "64E"), calibration);
  KeyMap sensor;
  add_driver(node, model, node.setup.replay.captures.empty(), sensor);
  add_outputs(node, model, calibration, sensor);
  node.setup.keys.vehicle = add_frames(node, node.text("frame_id", "velodyne"), sensor);
  node.move("ros-drivers/velodyne", sensor);
  node.setup.keys.sensors = {{"velodyne", std::move(sensor)}};
  return node.finish();
}

DropinSetup nebula_setup(const NodeParameters& parameters) {
  Translation node(parameters);
  const Model& model = model_named(nebula_names, "sensor_model", node.text("sensor_model", ""));
  KeyMap sensor{{"model", std::string(model.name)},
                {"frame_id", as_frame(node.text("frame_id", "velodyne"))}};
  sensor.emplace_back("cut_angle", node.number("scan_phase", 0) * pi_d / 180);
  node.move("nebula", sensor);
  sensor.emplace_back("points_topic", "velodyne_points");
  node.warn("the cloud has the fields x y z intensity ring time (theirs has more)");
  node.setup.keys.sensors = {{"velodyne", std::move(sensor)}};
  return node.finish();
}

}  // namespace lidard
