// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The keys that merged and virtual scans share.
#include <algorithm>
#include <cmath>

#include "core/base/angle.h"
#include "daemon/config/sections.h"

namespace lidard {
namespace {

using namespace keys;

constexpr double longest_period_s = 3600;
constexpr std::size_t default_beams_per_turn = 1440;

const Words<Profile> profiles{
    {"strict", Profile::strict}, {"safety", Profile::safety}, {"flatten", Profile::flatten}};
const Words<EmptyBeam> beams{{"inf", EmptyBeam::inf},
                             {"nan", EmptyBeam::nan},
                             {"range_max_plus_one", EmptyBeam::range_max_plus_one},
                             {"minus_inf", EmptyBeam::minus_inf},
                             {"zero", EmptyBeam::zero}};

template <class Output>
KeyOf<Output> profile_row() {
  return word("profile", &Output::profile, profiles, "how the scan says what is known");
}
/// Encoding of beams without a range.
Keys<OutputScanConfig> beam_rows() {
  using O = OutputScanConfig;
  return {word("empty", &O::empty, beams, "what stands where nothing is"),
          word("unobserved", &O::unobserved, beams, "what stands where nothing is known")};
}

Keys<ScanGridSpec> grid_rows() {
  using G = ScanGridSpec;
  return {
      angle("angle_min", &G::angle_min, -two_pi, two_pi, "first beam"),
      angle("angle_max", &G::angle_max, -two_pi, two_pi, "last beam"),
      whole("beams", &G::beams, 2, 32767, "number of beams, in place of angle_increment")
          .by_default("1440 for a full turn"),
      angle("angle_increment", &G::angle_increment, 0, pi_d, "between beams")
          .by_default("a 1440th of a turn"),
      number("time_increment", &G::time_increment, 0, longest_period_s, "s", "between beams"),
      number("scan_time", &G::scan_time, 0, longest_period_s, "s", "between scans; 0: that of the sources"),
      number("range_min", &G::range_min, 0, farthest_m, "m", "nearer returns are left out")
          .by_default("of the nearest-sighted source"),
      number("range_max", &G::range_max, 0, farthest_m, "m", "farther returns are left out")
          .by_default("of the farthest-sighted source")};
}

Keys<OutputScanConfig> height_rows() {
  using O = OutputScanConfig;
  return {number("min_height", &O::min_height, -farthest_m, farthest_m, "m",
                 "lower returns are left out, in the frame of the scan")
              .unless_set("no limit")
              .or_else(-farthest_m),
          number("max_height", &O::max_height, -farthest_m, farthest_m, "m",
                 "higher returns are left out, in the frame of the scan")
              .unless_set("no limit")
              .or_else(farthest_m)};
}

/// The key that a message about the grid refers to: the first one in the message that is in the file.
const Value& place_of_complaint(const std::string& complaint, const Mapping& yaml) {
  const Value* place = &yaml.self();
  std::size_t earliest = std::string::npos;
  for (const Key& key : output_keys()) {
    const std::size_t mentioned = complaint.find(key.name);
    if (!yaml.has(key.name) || mentioned >= earliest) continue;
    earliest = mentioned;
    place = &yaml.where(key.name);
  }
  return *place;
}

void check_grid(const ScanGridSpec& spec, const Mapping& yaml, Reading& reading) {
  const auto grid = make_grid(spec);
  const std::string path = yaml.self().path();
  if (!grid) {
    throw ConfigError(place_of_complaint(grid.reason(), yaml).place(), path + ": " + grid.reason());
  }
  if (grid->beams < gmapping_beam_limit) return;
  reading.warn(yaml.where(yaml.has("beams") ? "beams" : "angle_increment").place(),
               path + " has " + std::to_string(grid->beams) + " beams; gmapping needs fewer than " +
                   std::to_string(gmapping_beam_limit) +
                   ": set beams lower where gmapping is to use the scan");
}

}  // namespace

const Keys<OutputScanConfig>& output_keys() {
  using O = OutputScanConfig;
  static const Keys<O> rows = [] {
    Keys<O> all = joined<O>({{profile_row<O>()}, within(&O::grid, grid_rows()), beam_rows(), height_rows()});
    for (Key& key : all) key.live = key.name != "beams";  // which angle_increment stands for
    return all;
  }();
  return rows;
}

const KeyOf<AlsoScanConfig>& also_profile() {
  static const KeyOf<AlsoScanConfig> key = profile_row<AlsoScanConfig>();
  return key;
}

SourceLimits::SourceLimits(const SensorConfig& sensor) : SourceLimits(ScanGridSpec()) {
  if (sensor.model == nullptr) return;
  range_min = sensor.model->range_min;
  range_max = sensor.model->range_max;
}

void default_ranges(const std::vector<SourceLimits>& sources, ScanGridSpec& grid) {
  if (sources.empty()) return;
  const auto nearest = std::min_element(
      sources.begin(), sources.end(), [](const auto& a, const auto& b) { return a.range_min < b.range_min; });
  const auto farthest = std::max_element(
      sources.begin(), sources.end(), [](const auto& a, const auto& b) { return a.range_max < b.range_max; });
  grid.range_min = nearest->range_min;
  grid.range_max = farthest->range_max;
}

void check_output(Mapping& yaml, OutputScanConfig& output, Reading& reading) {
  if (output.min_height && output.max_height && *output.max_height <= *output.min_height)
    yaml.where(yaml.has("max_height") ? "max_height" : "min_height")
        .fail("leaves no height between min_height and max_height", "min_height < max_height");
  ScanGridSpec& grid = output.grid;
  if (grid.angle_max < grid.angle_min) {
    grid.angle_max = sector_between(grid.angle_min, grid.angle_max).last;
    if (grid.angle_max > two_pi) grid.angle_min -= two_pi, grid.angle_max -= two_pi;
  }
  if (!grid.beams && !grid.angle_increment) {
    if (std::abs(grid.angle_max - grid.angle_min - two_pi) < 1e-9)
      grid.beams = default_beams_per_turn;
    else
      grid.angle_increment = two_pi / static_cast<double>(default_beams_per_turn);
  }
  check_grid(grid, yaml, reading);
}

void check_sector(const Mapping& yaml, const Sector& sector) {
  if (sector.width() > 0) return;
  yaml.where(yaml.has("angle_max") ? "angle_max" : "angle_min")
      .fail("is a sector of no width", "angle_min and angle_max of a sector, counter-clockwise");
}

bool knows_free_space(const OutputScanConfig& output, const std::vector<AlsoScanConfig>& also) {
  return output.profile != Profile::flatten || std::any_of(also.begin(), also.end(), [](const auto& one) {
           return one.profile != Profile::flatten;
         });
}

void read_also(const Mapping& yaml, std::vector<AlsoScanConfig>& also) {
  const auto section = yaml.find("also");
  if (!section) return;
  Mistakes mistakes;
  for (const auto& [topic, value] : named_entries(*section, &mistakes)) {
    mistakes.attempt([&, &topic = topic, &value = value] {
      check_entry_name(topic, value);
      AlsoScanConfig one;
      one.topic = topic;
      also_profile().set(one, read_value(value, also_profile()));
      also.push_back(one);
    });
  }
  mistakes.throw_if_any();
}

}  // namespace lidard
