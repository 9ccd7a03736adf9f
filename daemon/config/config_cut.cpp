// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The keys of a virtual scan that say how surfaces and free space are found.
#include "daemon/config/config_cut.h"

#include "daemon/config/config_words.h"

namespace lidard {
namespace {

constexpr double farthest_m = 10000;

constexpr std::array<Word<CutMode>, 2> modes{{{"slice", CutMode::slice}, {"band", CutMode::band}}};
constexpr std::array<Word<GroundModel>, 3> grounds{
    {{"none", GroundModel::none}, {"plane", GroundModel::plane}, {"slope", GroundModel::slope}}};

GroundSettings read_ground(const Value& value) {
  GroundSettings ground;
  if (value.node().IsScalar()) {
    ground.model = read_word(value, grounds);
    return ground;
  }
  Mapping yaml(value, {"model", "z", "tolerance", "steepest"});
  ground.model = read_word(yaml.require("model", list_of(grounds)), grounds);
  if (const auto z = yaml.find("z")) ground.z = z->number(-farthest_m, farthest_m, "m");
  if (const auto tolerance = yaml.find("tolerance")) ground.tolerance = tolerance->number(0.001, 10, "m");
  const auto steepest = yaml.find("steepest");
  if (!steepest) return ground;
  if (ground.model != GroundModel::slope)
    steepest->fail(
        "is for a ground of model slope, and this is " + std::string(word_in(ground.model, grounds)),
        "model: slope, or no such key");
  ground.steepest = steepest->number(0.001, 1, "m of rise per m");
  return ground;
}

void read_also_scans(Mapping& yaml, const std::string& owner, ConfigClaims& claims, VirtualScanConfig& scan) {
  const auto section = yaml.find("also");
  if (!section) return;
  for (const auto& [name, value] : named_entries(*section)) {
    check_entry_name(name, value);
    scan.also.push_back(read_also(name, value));
    for (const std::string& frame : scan.virtual_laser_scan) {
      claims.publishes(scan.topic(frame, &scan.also.back()), owner, value);
      if (!scan.output_laser_topic.empty()) break;
    }
  }
}

/// A beam without return of these proves that nothing is there. Of other drivers' clouds nobody knows whether
/// a beam was fired.
double default_free_range(const SensorConfig& sensor) {
  return sensor.model != nullptr && sensor.model->has(Trait::silent_beams_are_free) ? sensor.model->range_max
                                                                                    : 0;
}

void refuse_without_visibility(const Mapping& yaml) {
  for (const std::string_view key : cut_keys) {
    if (key == "also" || !yaml.has(key)) continue;
    yaml.where(key).fail("is of no use for a scan of profile flatten, which is points alone",
                         "profile: strict or safety (or such a scan under also), or no such key");
  }
}

}  // namespace

const std::vector<std::string_view> cut_keys = {
    "also",   "mode",        "ground",        "keep_ground",
    "echoes", "range_noise", "free_required", "no_return_free_range"};

bool VirtualScanConfig::has_visibility() const {
  bool visibility = output.profile != Profile::flatten;
  for (const AlsoScanConfig& one : also) visibility |= one.profile != Profile::flatten;
  return visibility;
}

std::string VirtualScanConfig::topic(const std::string& frame, const AlsoScanConfig* further) const {
  const std::string own = output_laser_topic.empty() ? frame : output_laser_topic;
  return further == nullptr ? own : own + "/" + further->topic;
}

void read_cut(Mapping& yaml, const SensorConfig& source, const std::string& owner, Config& config,
              ConfigClaims& claims, VirtualScanConfig& scan) {
  read_also_scans(yaml, owner, claims, scan);
  if (!scan.has_visibility()) {
    refuse_without_visibility(yaml);
    return;
  }
  scan.no_return_free_range = default_free_range(source);
  if (const auto mode = yaml.find("mode")) scan.mode = read_word(*mode, modes);
  // Without a ground an obstacle is met only between two rings that both see it.
  scan.ground.model = GroundModel::slope;
  if (const auto ground = yaml.find("ground")) scan.ground = read_ground(*ground);
  if (const auto keep = yaml.find("keep_ground")) scan.keep_ground = keep->boolean();
  if (const auto echoes = yaml.find("echoes")) {
    const EchoChoice choice = read_echoes(*echoes);
    if (choice != EchoChoice::last && choice != EchoChoice::all)
      echoes->fail("is " + echoes->quoted() + ", but the surface of a cloud is made of the last returns",
                   "last or all");
    scan.early_returns = choice == EchoChoice::all;
  }
  if (const auto noise = yaml.find("range_noise")) scan.range_noise = noise->number(0.0005, 1, "m");
  if (const auto free = yaml.find("free_required"))
    scan.free_required = free->number(0.1, scan.output.grid.range_max, "m");
  if (const auto range = yaml.find("no_return_free_range"))
    scan.no_return_free_range = range->number(0, farthest_m, "m");
  // A beam that met something too near to measure is not free.
  for (SensorConfig& sensor : config.sensors) {
    if (sensor.name == source.name) sensor.driver.keep_too_near = true;
  }
}

const char* word_of(CutMode mode) { return word_in(mode, modes); }
const char* word_of(GroundModel model) { return word_in(model, grounds); }

}  // namespace lidard
