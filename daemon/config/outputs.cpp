// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The keys that merged and virtual scans share.
#include "daemon/config/outputs.h"

#include <algorithm>
#include <cmath>

#include "daemon/config/reading.h"
#include "daemon/config/rows.h"

namespace lidard {
namespace {

constexpr double longest_period_s = 3600;
constexpr std::size_t default_beams_per_turn = 1440;

Key profile_key(Profile& profile) {
  return {
      "profile", profile,
      keys::word({{"strict", Profile::strict}, {"safety", Profile::safety}, {"flatten", Profile::flatten}}),
      "how the scan says what is known"};
}

Keys grid_keys(ScanGridSpec& grid) {
  using namespace keys;
  return {{"angle_min", grid.angle_min, angle(-two_pi, two_pi), "first beam"},
          {"angle_max", grid.angle_max, angle(-two_pi, two_pi), "last beam"},
          {"beams", grid.beams, whole(2, 32767), "number of beams, in place of angle_increment",
           preset("1440 for a full turn")},
          {"angle_increment", grid.angle_increment, angle(0, pi_d), "between beams",
           preset("a 1440th of a turn")},
          {"time_increment", grid.time_increment, number(0, longest_period_s, "s"), "between beams"},
          {"scan_time", grid.scan_time, number(0, longest_period_s, "s"),
           "between scans; 0: that of the sources"},
          {"range_min", grid.range_min, number(0, farthest_m, "m"), "nearer returns are left out",
           preset("of the nearest-sighted source")},
          {"range_max", grid.range_max, number(0, farthest_m, "m"), "farther returns are left out",
           preset("of the farthest-sighted source")}};
}

/// The key that a message about the grid refers to: the first one in the message that is in the file.
const Value& value_complained_of(const std::string& complaint, const Keys& keys, const Mapping& yaml) {
  const Value* value = &yaml.self();
  std::size_t earliest = std::string::npos;
  for (const Key& key : keys) {
    const std::size_t mentioned = complaint.find(key.name);
    if (!yaml.has(key.name) || mentioned >= earliest) continue;
    earliest = mentioned;
    value = &yaml.where(key.name);
  }
  return *value;
}

void check_grid(ScanGridSpec& spec, const Mapping& yaml, Reading& reading) {
  const auto grid = make_grid(spec);
  const std::string path = yaml.self().path();
  if (!grid)
    throw ConfigError(value_complained_of(grid.reason(), grid_keys(spec), yaml).location(),
                      path + ": " + grid.reason());
  if (grid->beams < gmapping_beam_limit) return;
  reading.warn(yaml.where_first({"beams", "angle_increment"}).location(),
               path + " has " + std::to_string(grid->beams) + " beams; gmapping needs fewer than " +
                   std::to_string(gmapping_beam_limit) +
                   ": set beams lower where gmapping is to use the scan");
}

}  // namespace

Keys output_keys(OutputScanConfig& output) {
  using namespace keys;
  const Form beam = word({{"inf", EmptyBeam::inf},
                          {"nan", EmptyBeam::nan},
                          {"range_max_plus_one", EmptyBeam::range_max_plus_one},
                          {"minus_inf", EmptyBeam::minus_inf},
                          {"zero", EmptyBeam::zero}});
  const Form height = number(-farthest_m, farthest_m, "m");
  Keys all =
      join({{profile_key(output.profile)},
            grid_keys(output.grid),
            {{"empty", output.empty, beam, "what stands where nothing is"},
             {"unobserved", output.unobserved, beam, "what stands where nothing is known"},
             {"min_height", output.min_height, height, "lower returns are left out, in the frame of the scan",
              remark("no limit", -farthest_m)},
             {"max_height", output.max_height, height,
              "higher returns are left out, in the frame of the scan", remark("no limit", farthest_m)}}});
  for (Key& key : all) key.live = key.name != "beams";  // which angle_increment stands for
  return all;
}

void default_ranges(const std::vector<Source>& sources, ScanGridSpec& grid) {
  if (sources.empty()) return;
  const auto nearest = std::min_element(
      sources.begin(), sources.end(), [](const auto& a, const auto& b) { return a.range_min < b.range_min; });
  const auto farthest = std::max_element(
      sources.begin(), sources.end(), [](const auto& a, const auto& b) { return a.range_max < b.range_max; });
  grid.range_min = nearest->range_min;
  grid.range_max = farthest->range_max;
}

void check_output(const Mapping& yaml, OutputScanConfig& output, Reading& reading) {
  if (output.min_height && output.max_height && *output.max_height <= *output.min_height)
    yaml.where_first({"max_height", "min_height"})
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
  yaml.where_first({"angle_max", "angle_min"})
      .fail("is a sector of no width", "angle_min and angle_max of a sector, counter-clockwise");
}

bool knows_free_space(const OutputScanConfig& output, const std::vector<AlsoScanConfig>& also) {
  return output.profile != Profile::flatten || std::any_of(also.begin(), also.end(), [](const auto& one) {
           return one.profile != Profile::flatten;
         });
}

Key also_key(std::vector<AlsoScanConfig>& also) {
  KeyMap shown;
  for (AlsoScanConfig& one : also) shown.emplace_back(one.topic, profile_key(one.profile).value);
  const auto read = [&also](const Value& section) {
    read_each(section, {}, [&](const std::string& topic, const Value& value) {
      check_entry_name(topic, value);
      AlsoScanConfig one{topic};
      const Key profile = profile_key(one.profile);
      profile.set(read_value(value, profile));
      also.push_back(one);
    });
  };
  return {"also", shown, read, keys::special("{TOPIC: PROFILE, …}"),
          "more scans of the same evidence, by topic"};
}

}  // namespace lidard
