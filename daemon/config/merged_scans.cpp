// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/merged_scans.h"

#include <algorithm>
#include <set>
#include <utility>

#include "daemon/config/reading.h"
#include "daemon/config/rows.h"
#include "daemon/config/sensors.h"
#include "daemon/config/vehicle.h"

namespace lidard {
namespace {

using Merged = MergedScanConfig;

constexpr double least_required_m = 0.1;

KeyMap shown_settings(std::map<std::string, SourceSettings>& of_sources) {
  KeyMap map;
  for (auto& [name, one] : of_sources) map.emplace_back(name, shown_values(source_keys(one)));
  return map;
}

std::string expected_sources(const Reading& reading) {
  std::string expected = "names of sensors that give scans: " + names_of(reading.sensors, FrameKind::scan);
  const char* separator = "; or virtual scans: ";
  for (const Candidate& one : reading.candidates) {
    if (one.source.kind == Source::Kind::virtual_scan)
      expected += std::exchange(separator, ", ") + one.called;
  }
  return expected;
}

void read_one_source(const Value& entry, SourceSettings& settings) {
  const Mapping yaml = read_section(entry, source_keys(settings));
  if (settings.range_min >= settings.range_max)
    yaml.where_first({"range_max", "range_min"})
        .fail("leaves nothing between range_min and range_max", "range_min < range_max");
  check_sector(yaml, sector_between(settings.angle_min, settings.angle_max));
}

/// Reads `source_settings:`. Without return a beam proves free space as far as its sensor detects dark
/// targets, unless the file says otherwise.
void read_source_settings(const Mapping& yaml, const SourceList& list, Merged& merged) {
  const auto& sources = merged.laserscan_topics;
  for (const Source& source : list.sources) {
    if (source.free_range > 0 && merged.has_visibility())
      merged.source_settings.emplace(source.name, merged.source).first->second.no_return_free_range =
          source.free_range;
  }
  const auto section = yaml.find("source_settings");
  if (!section) return;
  std::vector<std::string_view> names(sources.begin(), sources.end());
  names.insert(names.end(), list.written.begin(), list.written.end());
  std::set<std::string> set_up;
  read_each(*section, names, [&](const std::string& name, const Value& entry) {
    const auto index = static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    const std::string& source = sources[index % sources.size()];
    if (!set_up.insert(source).second)
      entry.fail_at_key("is " + source + ", which has settings already", "one entry for each source");
    read_one_source(entry, merged.source_settings.emplace(source, merged.source).first->second);
  });
}

void read_free_required(const Mapping& yaml, Merged& merged) {
  if (const auto value = yaml.find("free_required"))
    merged.free_required = value->number(std::min(least_required_m, merged.output.grid.range_max),
                                         merged.output.grid.range_max, "m");
}

/// Reads `free_requires:`; the other sources prove nothing free.
void read_free_requires(const Mapping& yaml, const SourceList& list, Merged& merged) {
  const auto value = yaml.find("free_requires");
  if (!value) return;
  std::string expected = "sources of it:";
  for (const std::string& source : list.names) expected += " " + source;
  for (const Value& one : value->names(expected))
    merged.free_requires.push_back(list.names[list.index_of(one, expected)]);
  if (merged.free_requires.empty()) return;
  for (const std::string& source : list.names) {
    const auto& required = merged.free_requires;
    if (std::find(required.begin(), required.end(), source) != required.end()) continue;
    merged.source_settings.emplace(source, merged.source).first->second.proves_free = false;
  }
}

void claim_topics(const Mapping& yaml, Merged& merged, Reading& reading) {
  const std::string& owner = yaml.self().path();
  for (const Key& key : merged_keys(merged)) {
    const auto* const topic = std::get_if<std::string>(&key.value);
    if (key.kind == KeyKind::topic && topic != nullptr && !topic->empty())
      reading.claims.publishes(*topic, owner, yaml.where(key.name));
  }
  for (const AlsoScanConfig& also : merged.also)
    reading.claims.publishes(also.topic, owner, yaml.inside("also").where(also.topic));
}

/// Points alone prove nothing, so they are no evidence for what is free or hidden.
void refuse_flat_sources(const SourceList& sources, const Merged& merged) {
  if (!merged.has_visibility()) return;
  for (std::size_t i = 0; i < sources.sources.size(); ++i) {
    if (sources.sources[i].proves_nothing)
      sources.values[i].fail(
          "names " + sources.values[i].quoted() + ", a virtual scan of profile flatten, which proves nothing",
          "a virtual scan of profile strict or safety, or profile: flatten here");
  }
}

void warn_without_footprint(const Mapping& yaml, const Merged& merged, Reading& reading) {
  if (!merged.has_visibility() || !reading.vehicle.footprint.empty()) return;
  reading.warn(yaml.where("profile").location(),
               yaml.self().path() +
                   " is to say what is observed, but vehicle.footprint is not set: where the vehicle hides "
                   "the way from " +
                   merged.destination_frame + " outward, every beam stays unobserved");
}

/// What the keys of an entry have to fulfil together, and what follows from them.
void check_merged_scan(const Mapping& yaml, const SourceList& sources, Merged& merged, Reading& reading) {
  Mistakes mistakes;
  mistakes.attempt(
      [&] { check_destination(yaml, merged.destination_frame, merged.destination_pose, reading); });
  mistakes.attempt([&] { claim_topics(yaml, merged, reading); });
  mistakes.attempt([&] { check_output(yaml, merged.output, reading); });
  mistakes.attempt([&] { refuse_flat_sources(sources, merged); });
  mistakes.attempt([&] { check_schedule(yaml, sources, merged.schedule); });
  mistakes.throw_if_any();
  warn_without_footprint(yaml, merged, reading);
}

Merged read_merged(const std::string& name, const Value& entry, Reading& reading) {
  Mistakes mistakes;
  Merged merged;
  const Keys keys = merged_keys(merged);
  const Mapping yaml = mapping_of(entry, keys, mistakes);
  merged.name = name;
  merged.destination_frame = reading.vehicle.base_frame;
  merged.scan_destination_topic = name;
  const auto gives_scans = [](const Value&, const Reading&) { return FrameKind::scan; };
  SourceList sources;
  const bool has_sources = mistakes.attempt([&] {
    sources = read_sources(yaml, "laserscan_topics", expected_sources(reading), gives_scans, reading);
  });
  merged.laserscan_topics = sources.names;
  default_ranges(sources.sources, merged.output.grid);
  read_keys(yaml, keys, mistakes);
  // The limit is not known while a key is wrong.
  if (!mistakes.any()) mistakes.attempt([&] { read_free_required(yaml, merged); });
  mistakes.attempt([&] {
    if (merged.destination_frame == reading.vehicle.odometry_frame)
      yaml.where("destination_frame")
          .fail("is vehicle.odometry_frame", "a frame that moves with the vehicle");
  });
  if (has_sources) mistakes.attempt([&] { read_source_settings(yaml, sources, merged); });
  if (has_sources) mistakes.attempt([&] { read_free_requires(yaml, sources, merged); });
  // The rules between keys need all of them.
  mistakes.throw_if_any();
  check_merged_scan(yaml, sources, merged, reading);
  return merged;
}

}  // namespace

bool MergedScanConfig::has_visibility() const { return knows_free_space(output, also); }

std::vector<OutputTopic> MergedScanConfig::topics() const {
  std::vector<OutputTopic> topics{{scan_destination_topic, TopicKind::scan}};
  if (!status_topic.empty()) topics.push_back({status_topic, TopicKind::scan});
  for (const AlsoScanConfig& one : also) topics.push_back({one.topic, TopicKind::scan});
  if (!cloud_destination_topic.empty()) topics.push_back({cloud_destination_topic, TopicKind::cloud});
  return topics;
}

Keys source_keys(SourceSettings& settings) {
  using namespace keys;
  return {{"range_min", settings.range_min, number(0, farthest_m, "m"), "nearer returns are left out"},
          {"range_max", settings.range_max, number(0, farthest_m, "m"), "farther returns are left out"},
          {"angle_min", settings.angle_min, angle(-most_turn_rad, most_turn_rad),
           "begin of the sector that counts, in the sensor's frame"},
          {"angle_max", settings.angle_max, angle(-most_turn_rad, most_turn_rad),
           "its end, counter-clockwise from there"},
          {"no_return_free_range", settings.no_return_free_range, number(0, farthest_m, "m"),
           "how far a beam without return proves that nothing is there",
           preset("the range of a target of 10 % remission where it is known, else range_max of the source's "
                  "scan")}};
}

Keys merged_keys(Merged& merged) {
  using namespace keys;
  const double required = merged.free_required > 0 ? merged.free_required : merged.output.grid.range_max;
  return join(
      {{{"laserscan_topics", merged.laserscan_topics,
         special("names of sensors that give scans, or of virtual scans"),
         "the sources, by name or by the topic that they publish", needed},
        {"destination_frame", merged.destination_frame, frame, "the scan's origin",
         preset("vehicle.base_frame")},
        {"destination_pose", merged.destination_pose, pose, "of destination_frame in vehicle.base_frame",
         remark("from tf")},
        {"scan_destination_topic", merged.scan_destination_topic, topic, "the scan",
         preset("the entry's name")},
        {"cloud_destination_topic", merged.cloud_destination_topic, topic,
         "the returns of all sources as one cloud; empty: none", or_none},
        {"status_topic", merged.status_topic, topic,
         "a LaserScan of how far each beam is observed; as intensity 0 unobserved, 1 free, 2 hit, 3 a "
         "surface seen from behind, 4 a way with a gap; empty: none",
         or_none}},
       schedule_keys(merged.schedule, merged.on_missing_motion, merged.laserscan_topics),
       {{"source_settings", shown_settings(merged.source_settings), special("{SOURCE: {range_max: 8, …}}"),
         "windows and properties of single sources, by their name"}},
       output_keys(merged.output),
       {{"echoes", merged.source.echoes,
         word({{"first", EchoChoice::first},
               {"last", EchoChoice::last},
               {"strongest", EchoChoice::strongest},
               {"all", EchoChoice::all}}),
         "which echo of a beam counts"},
        {"veil_filter", merged.source.veil_filter, flag,
         "leaves out mixed pixels: returns between two surfaces where no surface is"},
        {"range_noise", merged.source.noise, number(0.0005, 1, "m"), "one standard deviation of the ranges"},
        {"free_required", KeyValue(required), number(least_required_m, farthest_m, "m"),
         "what must be observed for a beam to be free", preset("range_max")},
        {"free_requires", merged.free_requires, special("names of its sources"),
         "sources of which one must see all of a beam for it to be free, e.g. the lowest scanners; empty: "
         "any source"},
        also_key(merged.also)}});
}

void read_merged_scans(const Mapping& root, std::vector<Merged>& merged_scans, Reading& reading) {
  read_entries(root.find("merged_scans"), merged_scans, reading, read_merged);
}

}  // namespace lidard
