// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/microscan3.h"
#include "test/sim/scene_file.h"
#include "test/sim/velodyne.h"

namespace lidard::sim {
namespace {

Span milliseconds(double ms) { return span_from_seconds(ms / 1000); }

/// What a model adds to the keys that every sensor has.
struct Family {
  const char* name;
  double range_min, range_max;  ///< m
  ModelMaker (*parse)(const YamlReader& options);
};

ReturnMode return_mode(const YamlReader& yaml) {
  const std::string mode = yaml.text();
  if (mode == "strongest") return ReturnMode::strongest;
  if (mode == "last") return ReturnMode::last;
  if (mode == "dual") return ReturnMode::dual;
  yaml.fail("unknown return mode '" + mode + "'; expected strongest, last or dual");
}

ModelMaker parse_vlp16(const YamlReader& yaml) {
  yaml.allow({"return_mode", "rpm", "start_azimuth_deg", "telemetry_hz", "pps_locked"});
  VelodyneOptions options;
  if (yaml.has("return_mode")) options.mode = return_mode(yaml.at("return_mode"));
  if (yaml.has("rpm")) {
    const double deg_per_s = yaml.positive("rpm") * 6;
    options.sequence_turn_deg = deg_per_s * static_cast<double>(vlp16_table().sequence_ns) * 1e-9;
  }
  options.start_azimuth_deg = yaml.not_negative("start_azimuth_deg", 0);
  options.telemetry_hz = yaml.not_negative("telemetry_hz", 0);
  if (yaml.has("pps_locked")) options.pps_locked = yaml.at("pps_locked").flag();
  return make_velodyne(vlp16_table(), options);
}

ModelMaker parse_microscan3(const YamlReader& yaml) {
  yaml.allow({"start_deg", "end_deg", "resolution_deg", "scan_time_ms", "serial", "first_scan", "channel",
              "protective_field", "dirty_deg"});
  MicroScan3Options options;
  options.start_deg = yaml.number("start_deg", options.start_deg);
  options.end_deg = yaml.number("end_deg", options.end_deg);
  if (options.end_deg <= options.start_deg || options.end_deg - options.start_deg > 360) {
    yaml.fail("start_deg must be less than end_deg, by at most 360");
  }
  options.resolution_deg = yaml.positive("resolution_deg", options.resolution_deg);
  // The measurement block counts its bytes in 16 bits.
  if ((options.end_deg - options.start_deg) / options.resolution_deg > 16000) {
    yaml.fail("more than 16000 beams do not fit on the wire; raise resolution_deg");
  }
  options.scan_time = milliseconds(yaml.positive("scan_time_ms", 30));
  if (yaml.has("serial")) options.serial = static_cast<std::uint32_t>(yaml.at("serial").integer());
  if (yaml.has("first_scan"))
    options.first_scan = static_cast<std::uint32_t>(yaml.at("first_scan").integer());
  if (yaml.has("channel")) options.channel = static_cast<std::uint8_t>(yaml.at("channel").integer());
  options.protective_field = yaml.not_negative("protective_field", 0);
  const std::size_t sectors = yaml.has("dirty_deg") ? yaml.at("dirty_deg").list() : 0;
  for (std::size_t i = 0; i < sectors; ++i) {
    const Eigen::Vector2d sector = yaml.at("dirty_deg").at(i).vector2();
    options.dirty_deg.emplace_back(sector.x(), sector.y());
  }
  return make_microscan3(options);
}

// A further model: one row here, and its own file beside velodyne.cpp and microscan3.cpp (or a table in one
// of them).
const Family families[] = {
    {"velodyne_vlp16", 0.1, 100, parse_vlp16},
    {"sick_microscan3", 0, 40, parse_microscan3},
    {"sick_nanoscan3", 0, 40, parse_microscan3},
    {"sick_outdoorscan3", 0, 40, parse_microscan3},
};

const Family& find_family(const YamlReader& yaml) {
  std::string names;
  for (const Family& family : families) {
    if (yaml.text() == family.name) return family;
    names += std::string(names.empty() ? "" : ", ") + family.name;
  }
  yaml.fail("unknown model '" + yaml.text() + "'; expected one of " + names);
}

Pose parse_pose(const YamlReader& yaml) {
  yaml.allow({"xyz", "rpy", "rpy_deg"});
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  if (yaml.has("rpy")) rpy = yaml.at("rpy").vector3();
  if (yaml.has("rpy_deg")) rpy = yaml.at("rpy_deg").vector3() * rad_per_deg;
  return make_pose(yaml.at("xyz").vector3(), rpy);
}

}  // namespace

SensorEntry parse_sensor(const std::string& name, const YamlReader& yaml) {
  yaml.allow({"model", "pose", "from", "to", "phase_ms", "clock_offset", "latency_us", "jitter_us", "noise",
              "divergence_mrad", "range_min", "range_max", "options"});
  const Family& family = find_family(yaml.at("model"));
  SensorEntry sensor;
  sensor.name = name;
  sensor.model = family.name;
  if (yaml.has("pose")) sensor.mount = parse_pose(yaml.at("pose"));
  sensor.from = yaml.at("from").endpoint();
  sensor.to = yaml.at("to").endpoint();
  sensor.phase = milliseconds(yaml.not_negative("phase_ms", 0));
  sensor.clock_offset = span_from_seconds(yaml.number("clock_offset", 0));
  sensor.latency = milliseconds(yaml.not_negative("latency_us", 20) / 1000);
  sensor.jitter = milliseconds(yaml.not_negative("jitter_us", 0) / 1000);
  sensor.noise = yaml.not_negative("noise", 0);
  sensor.divergence = yaml.not_negative("divergence_mrad", 0) / 1000;
  sensor.range_min = yaml.not_negative("range_min", family.range_min);
  sensor.range_max = yaml.positive("range_max", family.range_max);
  const YamlReader none(yaml.file(), YAML::Node(YAML::NodeType::Map));
  sensor.make = family.parse(yaml.has("options") ? yaml.at("options") : none);
  return sensor;
}

}  // namespace lidard::sim
