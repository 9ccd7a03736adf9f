// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/velodyne_node_setup.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "core/base/number_text.h"
#include "daemon/config/config.h"
#include "daemon/dropin/parameter_reader.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

/// The names of ros-drivers/velodyne, and ours.
constexpr std::pair<const char*, const char*> model_names[] = {
    {"VLP16", "velodyne_vlp16"},         {"32C", "velodyne_vlp32c"},      {"32E", "velodyne_hdl32e"},
    {"VLS128", "velodyne_vls128"},       {"64E", "velodyne_hdl64e_s1"},   {"64E_S2", "velodyne_hdl64e_s2"},
    {"64E_S2.1", "velodyne_hdl64e_s21"}, {"64E_S3", "velodyne_hdl64e_s3"}};

/// What is accepted but has no effect here, and why.
constexpr std::pair<const char*, const char*> without_effect[] = {
    {"npackets", "clouds are whole revolutions at any speed and in any return mode"},
    {"fixed_frame", "clouds stay in the sensor's frame"},
    {"target_frame", "clouds stay in the sensor's frame"},
    {"gps_time", "stamps follow the sensor's clock but count in the host's time"},
    {"enabled", "the node is enabled while it runs"}};

/// Accepted in silence: they change nothing that a user could miss.
constexpr const char* needless[] = {"rpm", "diagnostic_frequency_tolerance", "manager", "max_rate"};

std::string model_of(const std::string& given, const std::string& calibration) {
  const std::string file = calibration.substr(calibration.rfind('/') + 1);
  // velodyne_driver knows no Puck Hi-Res: its users name a VLP-16 with the other calibration.
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

class Writer {
 public:
  Writer() {
    yaml_ << YAML::BeginMap << YAML::Key << "sensors" << YAML::Value << YAML::BeginMap << YAML::Key
          << "velodyne" << YAML::Value << YAML::BeginMap;
  }
  void text(const char* key, const std::string& value) { yaml_ << YAML::Key << key << YAML::Value << value; }
  void number(const char* key, double value) { text(key, number_text(value)); }
  std::string finish() {
    yaml_ << YAML::EndMap << YAML::EndMap << YAML::EndMap;
    return yaml_.c_str() + std::string("\n");
  }

 private:
  YAML::Emitter yaml_;
};

/// velodyne_driver's parameters but for those of captures.
void write_driver(ParameterReader& reader, Writer& writer, const std::string& model, bool live) {
  writer.text("model", model);
  const std::string address = reader.text("device_ip", "");
  const double port = reader.number("port", 2368);
  const std::string packets = reader.text("packet_topic", "");
  if (!packets.empty()) {
    writer.text("packet_topic", packets);
  } else {
    if (!address.empty()) writer.text("ip_address", address);
    writer.number("ip_port", port);
    // Several of these nodes may run on one machine, and those they stand in for do not listen there either.
    const double telemetry = reader.number("telemetry_port", live ? 0 : find_model(model)->telemetry_port);
    if (find_model(model)->telemetry_port != 0) writer.number("telemetry_port", telemetry);
  }
  writer.text("frame_id", reader.text("frame_id", "velodyne"));
  writer.number("time_offset", reader.number("time_offset", 0));
  writer.text("frame_stamp", reader.flag("timestamp_first_packet") ? "first" : "last");
  // Without a cut of the user's the seam lies behind, where scans go from +pi to -pi.
  const double cut = reader.number("cut_angle", -0.01);
  writer.number("cut_angle", cut < 0 ? M_PI : cut);
}

/// velodyne_pointcloud's and velodyne_laserscan's.
void write_outputs(ParameterReader& reader, Writer& writer, const std::string& model,
                   const std::string& calibration) {
  writer.number("min_range", reader.number("min_range", 0.9));
  writer.number("max_range", reader.number("max_range", 130));
  writer.number("view_direction", reader.number("view_direction", 0));
  writer.number("view_width", std::min(reader.number("view_width", 2 * M_PI), 2 * M_PI));
  writer.text("organize_cloud", reader.flag("organize_cloud") ? "firings" : "false");
  const bool has_table = model.find("hdl64e") == std::string::npos;
  if (!calibration.empty()) writer.text("calibration", calibration);
  if (!calibration.empty() || has_table) writer.text("calibration_model", "ros_drivers");
  const double ring = reader.number("laserscan_ring", reader.number("ring", -1));
  if (ring < 0)
    writer.text("scan_ring", "auto");
  else
    writer.number("scan_ring", ring);
  writer.number("scan_resolution", reader.number("laserscan_resolution", reader.number("resolution", 0.007)));
  writer.text("points_topic", "velodyne_points");
  writer.text("scan_topic", "scan");
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
  for (const auto& [name, why] : without_effect) {
    const std::string value = reader.text(name, "");
    const bool wanted = !value.empty() && value != "0" && value != "false" && std::string(name) != "enabled";
    if (wanted || (std::string(name) == "enabled" && value == "false"))
      setup.warnings.push_back("parameter ~" + std::string(name) + " has no effect: " + why);
  }
  for (const char* name : needless) reader.text(name, "");
  read_replay(reader, setup.replay);
  const std::string calibration = reader.text("calibration", "");
  const std::string model = model_of(reader.text("model", "64E"), calibration);
  Writer writer;
  write_driver(reader, writer, model, setup.replay.captures.empty());
  write_outputs(reader, writer, model, calibration);
  setup.yaml = writer.finish();
  reader.remark_on_rest(setup.warnings);
  return setup;
}

}  // namespace lidard
