// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "test/sim/devices/velodyne.h"
#include "test/sim/servers/scene_models.h"

namespace lidard::sim {
namespace {

ReturnMode return_mode(const VelodyneTable& table, const YamlReader& yaml) {
  const std::string mode = yaml.text();
  if (mode == "strongest") return ReturnMode::strongest;
  if (mode == "last") return ReturnMode::last;
  if (mode == "dual" && table.has_dual) return ReturnMode::dual;
  if (mode == "dual_confidence" && table.has_confidence()) return ReturnMode::dual_confidence;
  std::string known = "strongest, last";
  if (table.has_dual) known += ", dual";
  if (table.has_confidence()) known += ", dual_confidence";
  yaml.fail("unknown return mode '" + mode + "' of " + table.name + "; expected one of " + known);
}

std::string timing_name(const VelodyneTable& table, const YamlReader& yaml) {
  std::string known;
  for (const VelodyneTiming& timing : table.timings) {
    if (timing.name == yaml.text()) return timing.name;
    known += (known.empty() ? "" : ", ") + timing.name;
  }
  yaml.fail("unknown timing '" + yaml.text() + "' of " + table.name + "; expected " +
            (known.empty() ? "none: it has only one" : "one of " + known));
}

AzimuthSector parse_sector(const YamlReader& yaml) {
  yaml.allow({"start_deg", "end_deg"});
  const AzimuthSector sector{yaml.at("start_deg").number(), yaml.at("end_deg").number()};
  // So wide that no turn misses it between two firings.
  const double width = std::fmod(sector.end_deg - sector.start_deg + 360, 360.0);
  const auto inside = [](double degrees) { return degrees >= 0 && degrees < 360; };
  if (!inside(sector.start_deg) || !inside(sector.end_deg) || width < 3) {
    yaml.fail("start_deg and end_deg must be in 0..360, at least 3 apart clockwise");
  }
  return sector;
}

std::optional<double> parse_turn(const VelodyneTiming& timing, const YamlReader& yaml) {
  std::optional<double> turn_deg;
  if (yaml.has("rpm") && yaml.has("turn_deg")) yaml.fail("rpm and turn_deg say the same; leave one out");
  if (yaml.has("turn_deg")) turn_deg = yaml.not_negative("turn_deg", 0);
  if (yaml.has("rpm")) {
    const double deg_per_s = yaml.not_negative("rpm", 0) * 6;
    turn_deg = deg_per_s * static_cast<double>(timing.period_ns()) * 1e-9;
  }
  if (turn_deg && *turn_deg > 1.5) yaml.fail("no motor turns so fast; expected at most 3600 rpm");
  return turn_deg;
}

ModelMaker parse_velodyne(const VelodyneTable& table, const YamlReader& yaml) {
  yaml.allow({"return_mode", "rpm", "turn_deg", "start_azimuth_deg", "telemetry_hz", "pps_locked", "fov",
              "timing", "rest_spread_us", "old_stamp"});
  VelodyneOptions options;
  if (yaml.has("return_mode")) options.mode = return_mode(table, yaml.at("return_mode"));
  if (yaml.has("timing")) options.timing = timing_name(table, yaml.at("timing"));
  options.turn_deg = parse_turn(velodyne_timing(table, options.timing), yaml);
  options.start_azimuth_deg = yaml.not_negative("start_azimuth_deg", 0);
  options.telemetry_hz = yaml.not_negative("telemetry_hz", 0);
  options.pps_locked = yaml.flag("pps_locked");
  if (yaml.has("fov")) options.fov = parse_sector(yaml.at("fov"));
  if (options.fov && options.turn_deg == 0.0) yaml.fail("fov needs a motor that turns; raise rpm");
  options.rest_spread_ns = std::llround(yaml.not_negative("rest_spread_us", 0.7) * 1000);
  if (options.rest_spread_ns > 1'900) yaml.fail("rest_spread_us must be below the mean rest, 1.9");
  options.old_stamp = yaml.flag("old_stamp");
  if (yaml.has("old_stamp") && std::string(table.name) != "velodyne_hdl32e")
    yaml.at("old_stamp").fail("only velodyne_hdl32e has it");
  return make_velodyne(table, options);
}

}  // namespace

std::vector<SceneModel> velodyne_models() {
  std::vector<SceneModel> models;
  for (const VelodyneTable& table : velodyne_tables()) {
    models.push_back(
        {table.name, 0.1, table.range_max, [&table](const YamlReader& options, SensorEntry& entry) {
           entry.make = parse_velodyne(table, options);
         }});
  }
  return models;
}

}  // namespace lidard::sim
