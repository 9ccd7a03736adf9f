// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/microscan3.h"
#include "test/sim/servers/cola_scene.h"
#include "test/sim/servers/hokuyo_scene.h"
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/scene_sick.h"
#include "test/sim/servers/scene_velodyne.h"

namespace lidard::sim {
namespace {

Span milliseconds(double ms) { return span_from_seconds(ms / 1000); }

/// What a model adds to the keys that every sensor has.
struct Family {
  std::string name;
  double range_min, range_max;  ///< m
  std::function<ModelMaker(const YamlReader& options)> parse;
  /// Instead, for one that has a TCP port.
  std::function<void(const YamlReader& options, SensorEntry& entry)> parse_entry{};
};

void parse_microscan3(const YamlReader& yaml, SensorEntry& entry) {
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
  entry.make = make_microscan3(options);
  entry.settings = std::make_shared<const SafetySettings>(safety_settings(options, entry));
}

std::vector<Family> make_families() {
  std::vector<Family> families;
  for (const VelodyneTable& table : velodyne_tables()) {
    families.push_back({table.name, 0.1, table.range_max,
                        [&table](const YamlReader& options) { return parse_velodyne(table, options); }});
  }
  for (const char* name : {"sick_microscan3", "sick_nanoscan3", "sick_outdoorscan3"}) {
    families.push_back({name, 0, 40, {}, parse_microscan3});
  }
  for (const ColaFamily& cola : cola_families()) {
    families.push_back({cola.name,
                        cola.range_min,
                        cola.range_max,
                        {},
                        [name = cola.name](const YamlReader& options, SensorEntry& entry) {
                          parse_cola(name, options, entry);
                        }});
  }
  for (const HokuyoFamily& hokuyo : hokuyo_families()) {
    families.push_back({hokuyo.name,
                        hokuyo.range_min,
                        hokuyo.range_max,
                        {},
                        [name = hokuyo.name](const YamlReader& options, SensorEntry& entry) {
                          parse_hokuyo(name, options, entry);
                        }});
  }
  for (const char* name : {"sick_picoscan150", "sick_picoscan120"})
    families.push_back({name, 0.05, 60, [](const YamlReader& o) { return parse_sick_segments(false, o); }});
  for (const char* name : {"sick_multiscan136", "sick_multiscan165", "sick_multiscan166"})
    families.push_back({name, 0.05, 60, [](const YamlReader& o) { return parse_sick_segments(true, o); }});
  return families;
}

const Family& find_family(const YamlReader& yaml) {
  static const std::vector<Family> families = make_families();
  std::string names;
  for (const Family& family : families) {
    if (yaml.text() == family.name) return family;
    names += (names.empty() ? "" : ", ") + family.name;
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
  const YamlReader options = yaml.has("options") ? yaml.at("options") : none;
  if (family.parse_entry) {
    family.parse_entry(options, sensor);
  } else {
    sensor.make = family.parse(options);
  }
  return sensor;
}

}  // namespace lidard::sim
