// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/angle.h"
#include "daemon/config/config.h"
#include "daemon/config/values.h"
#include "daemon/dropin/moving.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

/// The names of ros-drivers/velodyne and the models here.
constexpr std::pair<const char*, const char*> model_names[] = {
    {"VLP16", "velodyne_vlp16"},         {"32C", "velodyne_vlp32c"},      {"32E", "velodyne_hdl32e"},
    {"VLS128", "velodyne_vls128"},       {"64E", "velodyne_hdl64e_s1"},   {"64E_S2", "velodyne_hdl64e_s2"},
    {"64E_S2.1", "velodyne_hdl64e_s21"}, {"64E_S3", "velodyne_hdl64e_s3"}};

const std::map<std::string, std::string> nebula_models{
    {"VLP16", "velodyne_vlp16"}, {"VLP32", "velodyne_vlp32c"}, {"VLS128", "velodyne_vls128"}};

std::string model_of(const std::string& given, const std::string& calibration) {
  const std::string file = calibration.substr(calibration.rfind('/') + 1);
  // velodyne_driver has no Puck Hi-Res: its users set a VLP-16 with another calibration.
  if (given == "VLP16" && file.find("hires") != std::string::npos) return "velodyne_puck_hires";
  std::string expected;
  for (const auto& [theirs, ours] : model_names) {
    if (given == theirs) return ours;
    expected.append(expected.empty() ? "" : ", ").append(theirs);
  }
  if (find_model(given) != nullptr) return given;
  throw ConfigError("parameter ~model is '" + given + "'; expected one of " + expected +
                    ", or a name from `lidard models`");
}

/// Adds the parameters of velodyne_driver, except those of captures.
void add_driver(ParameterReader& reader, const std::string& model, bool live, KeyMap& sensor) {
  sensor.emplace_back("model", model);
  const std::string address = reader.text("device_ip", "");
  const double port = reader.number("port", 2368);
  const std::string packets = reader.text("packet_topic", "");
  // As the driver; packets from a topic are published already.
  if (reader.flag("publish_packets", packets.empty() ? "true" : "false"))
    sensor.emplace_back("raw_topic", "velodyne_packets");
  if (!packets.empty()) {
    sensor.emplace_back("packet_topic", packets);
  } else {
    if (!address.empty()) sensor.emplace_back("ip_address", address);
    sensor.emplace_back("ip_port", port);
    // Several of these nodes may run on one machine, and the original nodes do not listen there either.
    const double telemetry = reader.number("telemetry_port", live ? 0 : find_model(model)->telemetry_port);
    if (find_model(model)->telemetry_port != 0) sensor.emplace_back("telemetry_port", telemetry);
  }
  sensor.emplace_back("time_offset", reader.number("time_offset", 0));
  sensor.emplace_back("frame_stamp", reader.flag("timestamp_first_packet") ? "first" : "last");
  // By default the cut is behind, where scans go from +pi to -pi.
  const double cut = reader.number("cut_angle", -0.01);
  sensor.emplace_back("cut_angle", cut < 0 ? pi_d : cut);
}

/// Adds the parameters of velodyne_pointcloud and velodyne_laserscan.
void add_outputs(ParameterReader& reader, const std::string& model, const std::string& calibration,
                 KeyMap& sensor) {
  constexpr std::pair<const char*, double> plain[] = {
      {"min_range", 0.9}, {"max_range", 130}, {"view_direction", 0}};
  for (const auto& [name, preset] : plain) sensor.emplace_back(name, reader.number(name, preset));
  // As in the original, 0 is the whole turn, and a ring beyond the last one is the default.
  const double view = reader.number("view_width", two_pi);
  sensor.emplace_back("view_width", view > 0 ? std::min(view, two_pi) : two_pi);
  sensor.emplace_back("organize_cloud", reader.flag("organize_cloud") ? "firings" : "false");
  const bool has_table = model.find("hdl64e") == std::string::npos;
  if (!calibration.empty()) sensor.emplace_back("calibration", calibration);
  if (!calibration.empty() || has_table) sensor.emplace_back("calibration_model", "ros_drivers");
  const double ring = reader.number("laserscan_ring", reader.number("ring", -1));
  const auto rings = static_cast<double>(find_model(model)->beams);
  sensor.emplace_back("scan_ring",
                      ring < 0 || ring >= rings ? KeyValue(std::string("auto")) : KeyValue(ring));
  sensor.emplace_back("scan_resolution",
                      reader.number("laserscan_resolution", reader.number("resolution", 0.007)));
  sensor.emplace_back("points_topic", "velodyne_points");
  sensor.emplace_back("scan_topic", "scan");
}

/// Adds the frame of clouds and the fixed frame; returns the section `vehicle`.
KeyMap add_frames(ParameterReader& reader, const std::string& own, KeyMap& sensor) {
  const std::string fixed = without_slash(reader.text("fixed_frame", ""));
  const std::string target = without_slash(reader.text("target_frame", ""));
  sensor.emplace_back("frame_id", own);
  if (!(target + fixed).empty()) sensor.emplace_back("points_frame", target.empty() ? fixed : target);
  if (fixed.empty() || fixed == without_slash(own)) return {};
  sensor.emplace_back("deskew", true);
  // The motion of the sensor itself is used, so no other frame of the vehicle is needed.
  return {{"base_frame", own}, {"odometry_frame", fixed}};
}

void read_replay(ParameterReader& reader, ReplayOptions& replay) {
  const std::string capture = reader.text("pcap", "");
  const bool fast = reader.flag("read_fast");
  const bool once = reader.flag("read_once");
  const double delay = reader.number("repeat_delay", 0);
  const bool capture_time = reader.flag("pcap_time");
  if (capture.empty()) return;
  replay.captures = {capture};
  replay.rate = fast ? 0 : 1;
  replay.loop = !once;
  replay.loop_gap = span_from_seconds(std::clamp(delay, 0.001, 86400.0));
  replay.restamp = !capture_time;
}

}  // namespace

DropinSetup velodyne_node_setup(const NodeParameters& parameters) {
  DropinSetup setup;
  ParameterReader reader(parameters);
  read_replay(reader, setup.replay);
  const std::string calibration = reader.text("calibration", "");
  const std::string model = model_of(reader.text("model", "64E"), calibration);
  KeyMap sensor;
  add_driver(reader, model, setup.replay.captures.empty(), sensor);
  add_outputs(reader, model, calibration, sensor);
  if (KeyMap vehicle = add_frames(reader, reader.text("frame_id", "velodyne"), sensor); !vehicle.empty())
    setup.keys.emplace_back("vehicle", std::move(vehicle));
  reader.move("ros-drivers/velodyne", sensor, setup);
  setup.keys.emplace_back("sensors", KeyMap{{"velodyne", std::move(sensor)}});
  reader.remark_on_rest(setup.warnings);
  return setup;
}

DropinSetup nebula_setup(const NodeParameters& parameters) {
  DropinSetup setup;
  ParameterReader reader(parameters);
  const std::string model = reader.text("sensor_model", "");
  const auto found = nebula_models.find(model);
  if (found == nebula_models.end())
    throw ConfigError("parameter ~sensor_model is '" + model +
                      "', which lidard does not support; expected VLP16, VLP32 or VLS128");
  KeyMap sensor{{"model", found->second}, {"frame_id", as_frame(reader.text("frame_id", "velodyne"))}};
  sensor.emplace_back("cut_angle", reader.number("scan_phase", 0) * pi_d / 180);
  reader.move("nebula", sensor, setup);
  sensor.emplace_back("points_topic", "velodyne_points");
  setup.warnings.emplace_back("the cloud has the fields x y z intensity ring time (theirs has more)");
  setup.keys = {{"sensors", KeyMap{{"velodyne", std::move(sensor)}}}};
  reader.remark_on_rest(setup.warnings);
  return setup;
}

}  // namespace lidard
