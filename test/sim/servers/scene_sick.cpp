// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/devices/microscan3.h"
#include "test/sim/devices/sick_segments.h"
#include "test/sim/servers/scene_models.h"

namespace lidard::sim {
namespace {

void parse_microscan3(const YamlReader& yaml, SensorEntry& entry) {
  yaml.allow({"start_deg", "end_deg", "resolution_deg", "scan_time_ms", "serial", "first_scan",
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
  options.scan_time = span_from_seconds(yaml.positive("scan_time_ms", 30) / 1000);
  if (yaml.has("serial")) options.serial = static_cast<std::uint32_t>(yaml.at("serial").integer());
  if (yaml.has("first_scan"))
    options.first_scan = static_cast<std::uint32_t>(yaml.at("first_scan").integer());
  options.protective_field = yaml.not_negative("protective_field", 0);
  const std::size_t sectors = yaml.has("dirty_deg") ? yaml.at("dirty_deg").list() : 0;
  for (std::size_t i = 0; i < sectors; ++i) {
    const Eigen::Vector2d sector = yaml.at("dirty_deg").at(i).vector2();
    options.dirty_deg.emplace_back(sector.x(), sector.y());
  }
  entry.make = make_microscan3(options);
  entry.settings = std::make_shared<const SafetySettings>(safety_settings(options, entry));
}

SickSegmentsOptions::Format parse_format(const YamlReader& yaml) {
  const std::string name = yaml.text();
  if (name == "compact3") return SickSegmentsOptions::Format::compact3;
  if (name == "compact4") return SickSegmentsOptions::Format::compact4;
  if (name == "msgpack") return SickSegmentsOptions::Format::msgpack;
  yaml.fail("unknown format '" + name + "'; expected compact3, compact4 or msgpack");
}

void parse_single_layer(const YamlReader& yaml, SickSegmentsOptions& options) {
  options.start_deg = yaml.number("start_deg", options.start_deg);
  options.end_deg = yaml.number("end_deg", options.end_deg);
  if (options.end_deg <= options.start_deg || options.end_deg - options.start_deg > 360)
    yaml.fail("start_deg must be less than end_deg, by at most 360");
  options.resolution_deg = yaml.positive("resolution_deg", options.resolution_deg);
  options.segment_deg = yaml.positive("segment_deg", options.segment_deg);
  if (options.segment_deg / options.resolution_deg > 2000 || options.segment_deg < 2 * options.resolution_deg)
    yaml.fail("a segment must have 2 to 2000 beams; change segment_deg or resolution_deg");
}

void parse_segments(bool several_layers, const YamlReader& yaml, SensorEntry& entry) {
  SickSegmentsOptions options;
  options.several_layers = several_layers;
  if (several_layers) {
    yaml.allow({"format", "turn_ms", "echoes", "serial", "first_frame", "imu_hz"});
  } else {
    yaml.allow({"format", "turn_ms", "echoes", "serial", "first_frame", "imu_hz", "start_deg", "end_deg",
                "resolution_deg", "segment_deg", "keep_deg"});
    parse_single_layer(yaml, options);
  }
  if (yaml.has("format")) options.format = parse_format(yaml.at("format"));
  options.turn = span_from_seconds(yaml.positive("turn_ms", 50) / 1000);
  if (yaml.has("echoes")) {
    const std::int64_t echoes = yaml.at("echoes").integer();
    if (echoes < 1 || echoes > 3) yaml.at("echoes").fail("expected 1 to 3 echoes");
    options.echoes = static_cast<std::size_t>(echoes);
  }
  if (yaml.has("serial")) options.serial = static_cast<std::uint32_t>(yaml.at("serial").integer());
  if (yaml.has("first_frame"))
    options.first_frame = static_cast<std::uint64_t>(yaml.at("first_frame").integer());
  options.imu_hz = yaml.not_negative("imu_hz", options.imu_hz);
  if (yaml.has("keep_deg")) {
    const Eigen::Vector2d kept = yaml.at("keep_deg").vector2();
    options.keep_deg = {kept.x(), kept.y()};
  }
  entry.make = make_sick_segments(options);
}

void parse_picoscan(const YamlReader& yaml, SensorEntry& entry) { parse_segments(false, yaml, entry); }
void parse_multiscan(const YamlReader& yaml, SensorEntry& entry) { parse_segments(true, yaml, entry); }

}  // namespace

std::vector<SceneModel> safety_scanner_models() {
  return {{"sick_microscan3", 0, 40, parse_microscan3},
          {"sick_nanoscan3", 0, 40, parse_microscan3},
          {"sick_outdoorscan3", 0, 40, parse_microscan3}};
}

std::vector<SceneModel> sick_segment_models() {
  return {{"sick_picoscan150", 0.05, 60, parse_picoscan},
          {"sick_picoscan120", 0.05, 60, parse_picoscan},
          {"sick_multiscan136", 0.05, 60, parse_multiscan},
          {"sick_multiscan165", 0.05, 60, parse_multiscan},
          {"sick_multiscan166", 0.05, 60, parse_multiscan}};
}

}  // namespace lidard::sim
