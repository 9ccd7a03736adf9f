// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/scene_sick.h"

#include "test/sim/devices/sick_segments.h"

namespace lidard::sim {
namespace {

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

}  // namespace

ModelMaker parse_sick_segments(bool several_layers, const YamlReader& yaml) {
  SickSegmentsOptions options;
  options.several_layers = several_layers;
  if (several_layers) {
    yaml.allow({"format", "turn_ms", "echoes", "scale", "serial", "first_frame", "imu_hz"});
  } else {
    yaml.allow({"format", "turn_ms", "echoes", "scale", "serial", "first_frame", "imu_hz", "start_deg",
                "end_deg", "resolution_deg", "segment_deg", "keep_deg"});
    parse_single_layer(yaml, options);
  }
  if (yaml.has("format")) options.format = parse_format(yaml.at("format"));
  options.turn = span_from_seconds(yaml.positive("turn_ms", 50) / 1000);
  if (yaml.has("echoes")) {
    const std::int64_t echoes = yaml.at("echoes").integer();
    if (echoes < 1 || echoes > 3) yaml.at("echoes").fail("expected 1 to 3 echoes");
    options.echoes = static_cast<std::size_t>(echoes);
  }
  options.scale = yaml.positive("scale", options.scale);
  if (yaml.has("serial")) options.serial = static_cast<std::uint32_t>(yaml.at("serial").integer());
  if (yaml.has("first_frame"))
    options.first_frame = static_cast<std::uint64_t>(yaml.at("first_frame").integer());
  options.imu_hz = yaml.not_negative("imu_hz", options.imu_hz);
  if (yaml.has("keep_deg")) {
    const Eigen::Vector2d kept = yaml.at("keep_deg").vector2();
    options.keep_deg = {kept.x(), kept.y()};
  }
  return make_sick_segments(options);
}

}  // namespace lidard::sim
