// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/config/key_tables.h"
#include "daemon/config/reading.h"
#include "daemon/config/rows.h"

namespace lidard {

/// Reads the sections; `reading` sees every name they give away.
void read_vehicle(Mapping& root, Reading& reading);
void read_sensors(Mapping& root, Reading& reading);
void read_merged_scans(Mapping& root, Reading& reading);
void read_merged_clouds(Mapping& root, Reading& reading);
void read_virtual_scans(Mapping& root, Reading& reading);
void read_black_box(Mapping& root, Reading& reading);

/// Remarks about a configuration without mistakes: what is possible, and hardly meant.
void add_remarks(const Value& root, Reading& reading);
/// m from a point to a footprint; 0: inside, or there is none.
double distance_to(const std::vector<Eigen::Vector2d>& footprint, const Eigen::Vector2d& point);

/// `filter:` of a sensor, and what its keys have to fulfil together.
Keys<SensorConfig> filter_rows();
void check_filter(Mapping& parent, SensorConfig& sensor);

/// Brings the limits of the ring that is a scan in line with those of the cloud.
void set_ring_limits(SensorConfig& sensor);

/// The largest length that a key of an output takes, m.
constexpr double farthest_m = 10000;

/// Between which ranges a source measures, m.
struct SourceLimits {
  SourceLimits(const SensorConfig& sensor);
  SourceLimits(const ScanGridSpec& grid) : range_min(grid.range_min), range_max(grid.range_max) {}
  double range_min, range_max;
};
/// The ranges of a scan of these sources, unless the file says others.
void default_ranges(const std::vector<SourceLimits>& sources, ScanGridSpec& grid);
/// True if some of these scans is more than points.
bool knows_free_space(const OutputScanConfig& output, const std::vector<AlsoScanConfig>& also);
/// What the keys of an output have to fulfil together; fills in what follows from them.
void check_output(Mapping& yaml, OutputScanConfig& output, Reading& reading);
/// Refuses an angle_min and angle_max between which nothing lies.
void check_sector(const Mapping& yaml, const Sector& sector);
/// Reads `also:`.
void read_also(const Mapping& yaml, std::vector<AlsoScanConfig>& also);

/// The sources of a merged scan or cloud.
struct SourceList {
  std::string_view key;  ///< that they stand in
  std::vector<std::string> names;
  std::vector<std::string> written;  ///< as they are called there
  std::vector<NamedSource> named;
  std::vector<Value> values;
};
/// Reads the sources that `key` names, each once; `kind_of` says which frames are wanted of one.
SourceList read_sources(const Mapping& yaml, std::string_view key, const std::string& expected,
                        FrameKind (*kind_of)(const Value&, const Config&), Reading& reading);
constexpr const char* trigger_form = "the source whose sweeps trigger the output";
Keys<ScheduleSettings> policy_rows();
Keys<ScheduleSettings> patience_rows();
/// When a merged scan or cloud is published; `sources` are the names of its sources.
template <class Merged>
Keys<Merged> schedule_rows(std::vector<std::string> Merged::*sources) {
  const auto trigger = [sources](const Merged& merged) {
    const std::vector<std::string>& names = merged.*sources;
    const bool known = merged.schedule.trigger < names.size();
    return known ? KeyValue(names[merged.schedule.trigger]) : KeyValue();
  };
  const keys::Words<MissingMotion> motions{
      {"static", MissingMotion::stand}, {"wait", MissingMotion::wait}, {"drop", MissingMotion::drop}};
  return joined<Merged>(
      {within(&Merged::schedule, policy_rows()),
       {keys::special<Merged>("trigger", trigger_form, trigger,
                              "the source whose sweeps trigger the output, with policy trigger")
            .shown_if([](const Merged& merged) { return merged.schedule.policy == Policy::trigger; })},
       within(&Merged::schedule, patience_rows()),
       {keys::word("on_missing_motion", &Merged::on_missing_motion, motions,
                   "while poses of the vehicle are missing: as if it stood, wait for them, or no output")}});
}
void check_policy(Mapping& yaml, const SourceList& list, ScheduleSettings& schedule);
/// The pose of a destination that is base_frame itself is known.
void check_destination(const Mapping& yaml, const std::string& frame, std::optional<Pose>& pose,
                       Reading& reading);

/// Keys of merged and of virtual scans.
template <class Output>
KeyOf<Output> also_row() {
  const auto get = [](const Output& output) {
    KeyMap map;
    for (const auto& one : output.also) map.emplace_back(one.topic, shown_value(also_profile(), one));
    return map;
  };
  return keys::special<Output>("also", "{TOPIC: PROFILE, …}", get,
                               "more scans of the same evidence, by topic");
}
/// Reads the entries of a section, if there is one. Of those in which something is wrong the names are kept.
template <class Entry>
void read_entries(const std::optional<Value>& section, std::vector<Entry>& entries, Reading& reading,
                  Entry (*read_one)(const std::string& name, const Value& entry, Reading& reading)) {
  if (!section) return;
  Mistakes mistakes;
  for (const auto& [name, value] : named_entries(*section, &mistakes)) {
    const bool is_valid = mistakes.attempt([&, &name = name, &value = value] {
      check_entry_name(name, value);
      entries.push_back(read_one(name, value, reading));
    });
    if (!is_valid) reading.add_invalid_names(name, value);
  }
  mistakes.throw_if_any();
}

}  // namespace lidard
