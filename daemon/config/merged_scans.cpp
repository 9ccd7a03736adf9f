// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// `merged_scans:` of a configuration.
#include <algorithm>
#include <set>

#include "daemon/config/reading.h"
#include "daemon/config/sections.h"

namespace lidard {
namespace {

using namespace keys;
using Merged = MergedScanConfig;

const Words<EchoChoice> echo_choices{{"first", EchoChoice::first},
                                     {"last", EchoChoice::last},
                                     {"strongest", EchoChoice::strongest},
                                     {"all", EchoChoice::all}};

Keys<Merged> source_and_topic_rows() {
  return {special<Merged>(
              "laserscan_topics", "names of sensors that give scans, or of virtual scans",
              [](const Merged& merged) { return key_value(merged.laserscan_topics); },
              "the sources, by name or by the topic that they publish")
              .needed(),
          frame("destination_frame", &Merged::destination_frame, "the scan's origin")
              .by_default("vehicle.base_frame"),
          of_kind(KeyKind::pose, "destination_pose", &Merged::destination_pose,
                  "of destination_frame in vehicle.base_frame")
              .unless_set("from tf"),
          topic("scan_destination_topic", &Merged::scan_destination_topic, "the scan")
              .by_default("the entry's name"),
          topic("cloud_destination_topic", &Merged::cloud_destination_topic,
                "the returns of all sources as one cloud; empty: none")
              .or_empty(),
          topic("status_topic", &Merged::status_topic,
                "a LaserScan of how far each beam is observed; as intensity 0 unobserved, 1 free, 2 hit, "
                "3 a surface seen from behind, 4 a way with a gap; empty: none")
              .or_empty()};
}

KeyOf<Merged> source_settings_row() {
  const auto get = [](const Merged& merged) {
    KeyMap map;
    for (const auto& [name, one] : merged.source_settings)
      map.emplace_back(name, shown_values(source_keys(), one));
    return map;
  };
  return special<Merged>("source_settings", "{SOURCE: {range_max: 8, …}}", get,
                         "windows and properties of single sources, by their name");
}

KeyOf<Merged> free_required_row() {
  auto key = number("free_required", &Merged::free_required, 0.1, farthest_m, "m",
                    "what must be observed for a beam to be free")
                 .by_default("range_max");
  key.most = [](const Merged& merged) { return merged.output.grid.range_max; };
  key.get = [](const Merged& merged) {
    return key_value(merged.free_required > 0 ? merged.free_required : merged.output.grid.range_max);
  };
  return key;
}

KeyOf<Merged> free_requires_row() {
  return special<Merged>(
      "free_requires", "names of its sources",
      [](const Merged& merged) { return key_value(merged.free_requires); },
      "sources of which one must see all of a beam for it to be free, e.g. the lowest scanners; empty: any "
      "source");
}

Keys<Merged> fusion_rows() {
  return {word("echoes", &Merged::echoes, echo_choices, "which echo of a beam counts"),
          flag("veil_filter", &Merged::veil_filter,
               "leaves out mixed pixels: returns between two surfaces where no surface is"),
          number("range_noise", &Merged::range_noise, 0.0005, 1, "m", "one standard deviation of the ranges"),
          free_required_row(), free_requires_row()};
}

std::string expected_sources(const Config& config) {
  std::string expected = "names of sensors that give scans: " + names_of(config, FrameKind::scan);
  const char* separator = "; or virtual scans: ";
  for (const std::string& topic : virtual_topics(config)) {
    expected += separator + topic;
    separator = ", ";
  }
  return expected;
}

void read_one_source(const Value& entry, SourceSettings& settings) {
  Mistakes mistakes;
  const Mapping yaml = mapping_of(entry, source_keys(), mistakes);
  read_keys(yaml, source_keys(), settings, mistakes);
  mistakes.throw_if_any();
  if (settings.range_min >= settings.range_max)
    yaml.where(yaml.has("range_max") ? "range_max" : "range_min")
        .fail("leaves nothing between range_min and range_max", "range_min < range_max");
  check_sector(yaml, sector_between(settings.angle_min, settings.angle_max));
}

SourceSettings common_settings(const Merged& merged) {
  SourceSettings common;
  common.noise = merged.range_noise;
  common.echoes = merged.echoes;
  common.veil_filter = merged.veil_filter;
  return common;
}

/// Reads `source_settings:`. Without return a beam proves free space as far as its sensor detects dark
/// targets, unless the file says otherwise.
void read_source_settings(const Mapping& yaml, const SourceList& list, Merged& merged) {
  const SourceSettings common = common_settings(merged);
  const auto& sources = merged.laserscan_topics;
  for (std::size_t i = 0; i < sources.size() && merged.has_visibility(); ++i) {
    const SensorConfig* sensor = list.named[i].sensor;
    if (sensor == nullptr || sensor->model == nullptr || sensor->model->dark_range <= 0) continue;
    merged.source_settings.emplace(sources[i], common).first->second.no_return_free_range =
        sensor->model->free_range();
  }
  const auto section = yaml.find("source_settings");
  if (!section) return;
  std::vector<std::string_view> names(sources.begin(), sources.end());
  names.insert(names.end(), list.written.begin(), list.written.end());
  Mistakes mistakes;
  const Mapping entries(*section, names, &mistakes);
  std::set<std::string> set_up;
  for (const auto& [name, entry] : entries.entries()) {
    const auto place = static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
    const std::string& source = sources[place % sources.size()];
    mistakes.attempt([&, &entry = entry] {
      if (!set_up.insert(source).second)
        entry.fail_at_key("is " + source + ", which has settings already", "one entry for each source");
      read_one_source(entry, merged.source_settings.emplace(source, common).first->second);
    });
  }
  mistakes.throw_if_any();
}

/// Reads `free_requires:`; the other sources prove nothing free.
void read_free_requires(const Mapping& yaml, const SourceList& list, Merged& merged) {
  const auto value = yaml.find("free_requires");
  if (!value) return;
  std::string expected = "sources of it:";
  for (const std::string& source : list.names) expected += " " + source;
  for (const Value& one : value->names(expected)) {
    const std::string name = one.text();
    const auto count = static_cast<std::ptrdiff_t>(list.names.size());
    auto at = std::find(list.names.begin(), list.names.end(), name) - list.names.begin();
    if (at == count) at = std::find(list.written.begin(), list.written.end(), name) - list.written.begin();
    if (at == count) one.fail("is " + one.quoted() + ", which is no source of it", expected);
    merged.free_requires.push_back(list.names[static_cast<std::size_t>(at)]);
  }
  if (merged.free_requires.empty()) return;
  for (const std::string& source : list.names) {
    const auto& required = merged.free_requires;
    if (std::find(required.begin(), required.end(), source) != required.end()) continue;
    merged.source_settings.emplace(source, common_settings(merged)).first->second.proves_free = false;
  }
}

void claim_topics(const Mapping& yaml, const Merged& merged, Reading& reading) {
  const std::string& owner = yaml.self().path();
  const auto claim = [&](const std::string& topic, std::string_view key) {
    if (!topic.empty()) reading.claims.publishes(topic, owner, yaml.where(key));
  };
  claim(merged.scan_destination_topic, "scan_destination_topic");
  claim(merged.status_topic, "status_topic");
  claim(merged.cloud_destination_topic, "cloud_destination_topic");
  for (const AlsoScanConfig& also : merged.also)
    reading.claims.publishes(also.topic, owner, yaml.inside("also").where(also.topic));
}

/// Points alone prove nothing, so they are no evidence for what is free or hidden.
void refuse_flat_sources(const SourceList& sources, const Merged& merged) {
  if (!merged.has_visibility()) return;
  for (std::size_t i = 0; i < sources.named.size(); ++i) {
    const VirtualScanConfig* group = sources.named[i].virtual_group;
    if (group != nullptr && group->output.profile == Profile::flatten)
      sources.values[i].fail(
          "names " + sources.values[i].quoted() + ", a virtual scan of profile flatten, which proves nothing",
          "a virtual scan of profile strict or safety, or profile: flatten here");
  }
}

void warn_without_footprint(const Mapping& yaml, const Merged& merged, Reading& reading) {
  if (!merged.has_visibility() || !reading.config.vehicle.footprint.empty()) return;
  reading.warn(yaml.where("profile").place(),
               yaml.self().path() +
                   " is to say what is observed, but vehicle.footprint is not set: where the vehicle hides "
                   "the way from " +
                   merged.destination_frame + " outward, every beam stays unobserved");
}

Merged read_merged(const std::string& name, const Value& entry, Reading& reading) {
  Mistakes mistakes;
  Mapping yaml = mapping_of(entry, merged_keys(), mistakes);
  Merged merged;
  merged.name = name;
  merged.destination_frame = reading.config.vehicle.base_frame;
  merged.scan_destination_topic = name;
  const auto gives_scans = [](const Value&, const Config&) { return FrameKind::scan; };
  SourceList sources;
  const bool has_sources = mistakes.attempt([&] {
    sources = read_sources(yaml, "laserscan_topics", expected_sources(reading.config), gives_scans, reading);
  });
  merged.laserscan_topics = sources.names;
  std::vector<SourceLimits> limits;
  for (const NamedSource& source : sources.named)
    limits.push_back(source.sensor != nullptr ? SourceLimits(*source.sensor)
                                              : source.virtual_group->output.grid);
  default_ranges(limits, merged.output.grid);
  read_keys(yaml, merged_keys(), merged, mistakes);
  mistakes.attempt([&] {
    if (merged.destination_frame == reading.config.vehicle.odometry_frame)
      yaml.where("destination_frame")
          .fail("is vehicle.odometry_frame", "a frame that moves with the vehicle");
  });
  mistakes.attempt([&] { read_also(yaml, merged.also); });
  if (has_sources) mistakes.attempt([&] { read_source_settings(yaml, sources, merged); });
  if (has_sources) mistakes.attempt([&] { read_free_requires(yaml, sources, merged); });
  // The rules between keys need all of them.
  mistakes.throw_if_any();
  mistakes.attempt(
      [&] { check_destination(yaml, merged.destination_frame, merged.destination_pose, reading); });
  mistakes.attempt([&] { claim_topics(yaml, merged, reading); });
  mistakes.attempt([&] { check_output(yaml, merged.output, reading); });
  mistakes.attempt([&] { refuse_flat_sources(sources, merged); });
  mistakes.attempt([&] { check_policy(yaml, sources, merged.schedule); });
  mistakes.throw_if_any();
  warn_without_footprint(yaml, merged, reading);
  return merged;
}

}  // namespace

bool MergedScanConfig::has_visibility() const { return knows_free_space(output, also); }

const Keys<SourceSettings>& source_keys() {
  using S = SourceSettings;
  static const Keys<S> rows{
      number("range_min", &S::range_min, 0, farthest_m, "m", "nearer returns are left out"),
      number("range_max", &S::range_max, 0, farthest_m, "m", "farther returns are left out"),
      angle("angle_min", &S::angle_min, -most_turn_rad, most_turn_rad,
            "begin of the sector that counts, in the sensor's frame"),
      angle("angle_max", &S::angle_max, -most_turn_rad, most_turn_rad,
            "its end, counter-clockwise from there"),
      number("no_return_free_range", &S::no_return_free_range, 0, farthest_m, "m",
             "how far a beam without return proves that nothing is there")
          .by_default(
              "the range of a target of 10 % remission where it is known, else range_max of the source's "
              "scan")};
  return rows;
}

const Keys<Merged>& merged_keys() {
  static const Keys<Merged> all = joined<Merged>({source_and_topic_rows(),
                                                  schedule_rows(&Merged::laserscan_topics),
                                                  {source_settings_row()},
                                                  within(&Merged::output, output_keys()),
                                                  fusion_rows(),
                                                  {also_row<Merged>()}});
  return all;
}

void read_merged_scans(Mapping& root, Reading& reading) {
  read_entries(root.find("merged_scans"), reading.config.merged_scans, reading, read_merged);
}

}  // namespace lidard
