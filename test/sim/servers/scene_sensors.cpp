// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/scene_file.h"
#include "test/sim/servers/scene_models.h"

namespace lidard::sim {
namespace {

Span milliseconds(double ms) { return span_from_seconds(ms / 1000); }

const SceneModel& find_model(const YamlReader& yaml) {
  static const std::vector<SceneModel> models = [] {
    std::vector<SceneModel> all;
    for (const auto& family :
         {velodyne_models(), safety_scanner_models(), cola_models(), hokuyo_models(), sick_segment_models()})
      all.insert(all.end(), family.begin(), family.end());
    return all;
  }();
  std::string names;
  for (const SceneModel& model : models) {
    if (yaml.text() == model.name) return model;
    names += (names.empty() ? "" : ", ") + model.name;
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

/// A mount that is not where it was any more: a shift in the vehicle's frame and a turn about its own axes.
void parse_knock(const YamlReader& yaml, SensorEntry& sensor) {
  yaml.allow({"at", "xyz", "rpy_deg"});
  sensor.knocked_at = yaml.number("at", 0);
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  sensor.knocked = sensor.mount;
  sensor.knocked.translation() += yaml.has("xyz") ? yaml.at("xyz").vector3() : none;
  sensor.knocked.rotate(make_pose(none, yaml.has("rpy_deg")
                                            ? Eigen::Vector3d(yaml.at("rpy_deg").vector3() * rad_per_deg)
                                            : none)
                            .linear());
}

std::vector<double> parse_offsets(const YamlReader& yaml) {
  if (!yaml.node().IsSequence()) return {yaml.number()};
  std::vector<double> offsets;
  for (std::size_t i = 0; i < yaml.list(); ++i) offsets.push_back(yaml.at(i).number());
  return offsets;
}

}  // namespace

SensorEntry parse_sensor(const std::string& name, const YamlReader& yaml) {
  yaml.allow({"model", "pose", "from", "to", "phase_ms", "clock_offset", "latency_us", "jitter_us", "noise",
              "divergence_mrad", "range_min", "range_max", "range_offset", "knocked", "options"});
  const SceneModel& model = find_model(yaml.at("model"));
  SensorEntry sensor;
  sensor.name = name;
  sensor.model = model.name;
  if (yaml.has("pose")) sensor.mount = parse_pose(yaml.at("pose"));
  if (yaml.has("knocked")) parse_knock(yaml.at("knocked"), sensor);
  if (yaml.has("range_offset")) sensor.range_offsets = parse_offsets(yaml.at("range_offset"));
  sensor.from = yaml.at("from").endpoint();
  sensor.to = yaml.at("to").endpoint();
  sensor.phase = milliseconds(yaml.not_negative("phase_ms", 0));
  sensor.clock_offset = span_from_seconds(yaml.number("clock_offset", 0));
  sensor.latency = milliseconds(yaml.not_negative("latency_us", 20) / 1000);
  sensor.jitter = milliseconds(yaml.not_negative("jitter_us", 0) / 1000);
  sensor.noise = yaml.not_negative("noise", 0);
  sensor.divergence = yaml.not_negative("divergence_mrad", 0) / 1000;
  sensor.range_min = yaml.not_negative("range_min", model.range_min);
  sensor.range_max = yaml.positive("range_max", model.range_max);
  const YamlReader none(yaml.file(), YAML::Node(YAML::NodeType::Map));
  model.parse(yaml.has("options") ? yaml.at("options") : none, sensor);
  return sensor;
}

}  // namespace lidard::sim
