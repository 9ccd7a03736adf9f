// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/config_output_keys.h"

#include <algorithm>
#include <cmath>

namespace lidard {
namespace {

constexpr double farthest_m = 10000;
constexpr std::size_t default_beams_per_turn = 1440;
constexpr long most_beams = 32767;

const std::vector<std::string_view> output_keys = {
    "profile",        "beams",         "empty",     "unobserved",    "min_height",      "max_height",
    "angle_min",      "angle_min_deg", "angle_max", "angle_max_deg", "angle_increment", "angle_increment_deg",
    "time_increment", "scan_time",     "range_min", "range_max"};

void default_ranges(ScanGridSpec& grid, const Sources& sources) {
  double nearest = farthest_m;
  double farthest = 0;
  for (const SourceLimits& source : sources) {
    nearest = std::min(nearest, source.range_min);
    farthest = std::max(farthest, source.range_max);
  }
  grid.range_min = nearest;
  grid.range_max = farthest;
}

/// The key that a complaint about the grid is about: the first one it mentions that the user wrote.
const Value& place_of_complaint(const std::string& complaint, const Mapping& yaml) {
  const Value* place = &yaml.self();
  std::size_t earliest = std::string::npos;
  for (const std::string_view key : output_keys) {
    const std::string base(key.substr(0, key.rfind("_deg")));
    const std::size_t mentioned = complaint.find(base);
    if (!yaml.has(key) || mentioned >= earliest) continue;
    earliest = mentioned;
    place = &yaml.where(key);
  }
  return *place;
}

void default_increment(ScanGridSpec& grid) {
  if (grid.beams || grid.angle_increment) return;
  const bool full_turn = std::abs(grid.angle_max - grid.angle_min - 2 * M_PI) < 1e-9;
  if (full_turn)
    grid.beams = default_beams_per_turn;
  else
    grid.angle_increment = 2 * M_PI / static_cast<double>(default_beams_per_turn);
}

void check_grid(const ScanGridSpec& spec, Mapping& yaml, Config& config) {
  const auto grid = make_grid(spec);
  if (!grid) {
    const Value& place = place_of_complaint(grid.reason(), yaml);
    throw ConfigError(place.place().to_string() + ": " + yaml.self().path() + ": " + grid.reason());
  }
  if (grid->beams < gmapping_beam_limit) return;
  const Value& place = yaml.where(yaml.has("beams") ? "beams" : "angle_increment");
  warn(config, place.place(),
       yaml.self().path() + " has " + std::to_string(grid->beams) + " beams; gmapping needs fewer than " +
           std::to_string(gmapping_beam_limit) + ": set beams lower where gmapping is to use the scan");
}

void read_grid(Mapping& yaml, ScanGridSpec& grid) {
  if (const auto angle = yaml.angle("angle_min")) grid.angle_min = *angle;
  if (const auto angle = yaml.angle("angle_max")) grid.angle_max = *angle;
  grid.angle_increment = yaml.angle("angle_increment");
  if (const auto beams = yaml.find("beams"))
    grid.beams = static_cast<std::size_t>(beams->integer(2, most_beams));
  if (const auto time = yaml.find("time_increment"))
    grid.time_increment = time->number(0, longest_period_s, "s");
  if (const auto time = yaml.find("scan_time")) grid.scan_time = time->number(0, longest_period_s, "s");
  if (const auto range = yaml.find("range_min")) grid.range_min = range->number(0, farthest_m, "m");
  if (const auto range = yaml.find("range_max")) grid.range_max = range->number(0, farthest_m, "m");
}

void read_heights(Mapping& yaml, OutputScanConfig& output) {
  if (const auto height = yaml.find("min_height"))
    output.min_height = height->number(-farthest_m, farthest_m, "m");
  if (const auto height = yaml.find("max_height"))
    output.max_height = height->number(-farthest_m, farthest_m, "m");
  if (output.min_height && output.max_height && *output.max_height <= *output.min_height)
    yaml.where(yaml.has("max_height") ? "max_height" : "min_height")
        .fail("leaves no height between min_height and max_height", "min_height < max_height");
}

}  // namespace

SourceLimits::SourceLimits(const SensorConfig* sensor) : SourceLimits(ScanGridSpec()) {
  if (sensor->model == nullptr) return;
  range_min = sensor->model->range_min;
  range_max = sensor->model->range_max;
}

std::vector<std::string_view> with_output_keys(std::vector<std::string_view> keys) {
  keys.insert(keys.end(), output_keys.begin(), output_keys.end());
  return keys;
}

void read_output(Mapping& yaml, const Sources& sources, Config& config, OutputScanConfig& output) {
  if (const auto profile = yaml.find("profile")) output.profile = read_profile(*profile);
  if (const auto empty = yaml.find("empty")) output.empty = read_empty(*empty);
  if (const auto unobserved = yaml.find("unobserved")) output.unobserved = read_empty(*unobserved);
  read_heights(yaml, output);
  default_ranges(output.grid, sources);
  read_grid(yaml, output.grid);
  default_increment(output.grid);
  check_grid(output.grid, yaml, config);
}

}  // namespace lidard
