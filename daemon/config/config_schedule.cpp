// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "core/base/nearest.h"
#include "daemon/config/config_parts.h"
#include "daemon/config/config_words.h"

namespace lidard {
namespace {

constexpr double longest_wait_s = 3600;
constexpr double farthest_m = 10000;
constexpr double strongest = 1e9;
constexpr double most_outputs_per_s = 1000;

constexpr std::array<Word<Policy>, 3> policies{
    {{"complete", Policy::complete}, {"rate", Policy::rate}, {"trigger", Policy::trigger}}};
constexpr std::array<Word<MissingMotion>, 3> motions{
    {{"static", MissingMotion::stand}, {"wait", MissingMotion::wait}, {"drop", MissingMotion::drop}}};

/// Index of the source that `value` names: as it is named in laserscan_topics, or by its own name.
std::size_t read_source_name(const Value& value, const std::vector<std::string>& sources,
                             const std::vector<std::string>& written) {
  std::string expected = "one of laserscan_topics:";
  for (const std::string& source : sources) expected += " " + source;
  const std::string name = value.text(expected);
  auto found = std::find(sources.begin(), sources.end(), name);
  if (found == sources.end())
    found = sources.begin() + (std::find(written.begin(), written.end(), name) - written.begin());
  if (found == sources.end()) value.fail("is " + value.quoted() + ", which is no source of it", expected);
  return static_cast<std::size_t>(found - sources.begin());
}

void read_policy(Mapping& yaml, const std::vector<std::string>& written, MergedScanConfig& merged) {
  ScheduleSettings& schedule = merged.schedule;
  const auto policy = yaml.find("policy");
  if (policy) schedule.policy = read_word(*policy, policies);
  if (const auto rate = yaml.find("rate")) {
    schedule.rate = rate->number(0.01, most_outputs_per_s, "1/s");
    if (!policy) schedule.policy = Policy::rate;
    if (schedule.policy != Policy::rate)
      rate->fail_at_key("has no effect with policy: " + std::string(word_in(schedule.policy, policies)),
                        "policy: rate");
  }
  if (const auto trigger = yaml.find("trigger")) {
    schedule.trigger = read_source_name(*trigger, merged.laserscan_topics, written);
    if (!policy) schedule.policy = Policy::trigger;
    if (schedule.policy != Policy::trigger)
      trigger->fail_at_key("has no effect with policy: " + std::string(word_in(schedule.policy, policies)),
                           "policy: trigger");
  } else if (schedule.policy == Policy::trigger) {
    yaml.require("trigger", "the source whose sweeps trigger the output");
  }
}

void check_window(Mapping& yaml, const char* low, const char* high, double least, double most) {
  if (least < most) return;
  yaml.where(yaml.has(high) ? high : low)
      .fail(std::string("leaves nothing between ") + low + " and " + high, std::string(low) + " < " + high);
}

SourceSettings read_one_source(const Value& entry, SourceSettings settings) {
  Mapping yaml(entry, {"range_min", "range_max", "angle_min", "angle_min_deg", "angle_max", "angle_max_deg",
                       "intensity_min", "intensity_max", "range_noise", "no_return_free_range", "echoes",
                       "veil_filter"});
  if (const auto v = yaml.find("range_min")) settings.range_min = v->number(0, farthest_m, "m");
  if (const auto v = yaml.find("range_max")) settings.range_max = v->number(0, farthest_m, "m");
  if (const auto v = yaml.angle("angle_min")) settings.angle_min = *v;
  if (const auto v = yaml.angle("angle_max")) settings.angle_max = *v;
  if (const auto v = yaml.find("intensity_min"))
    settings.intensity_min = v->number(-strongest, strongest, "");
  if (const auto v = yaml.find("intensity_max"))
    settings.intensity_max = v->number(-strongest, strongest, "");
  if (const auto v = yaml.find("range_noise")) settings.noise = v->number(0.0005, 1, "m");
  if (const auto v = yaml.find("no_return_free_range"))
    settings.no_return_free_range = v->number(0, farthest_m, "m");
  if (const auto v = yaml.find("echoes")) settings.echoes = read_echoes(*v);
  if (const auto v = yaml.find("veil_filter")) settings.veil_filter = v->boolean();
  check_window(yaml, "range_min", "range_max", settings.range_min, settings.range_max);
  check_window(yaml, "angle_min", "angle_max", settings.angle_min, settings.angle_max);
  check_window(yaml, "intensity_min", "intensity_max", settings.intensity_min, settings.intensity_max);
  return settings;
}

}  // namespace

const std::vector<std::string_view> schedule_keys = {"policy",
                                                     "rate",
                                                     "trigger",
                                                     "deadline",
                                                     "max_age",
                                                     "lost_after",
                                                     "publish_when_empty",
                                                     "on_missing_motion",
                                                     "source_settings"};

const char* word_of(MissingMotion what) { return word_in(what, motions); }

void read_schedule(Mapping& yaml, const std::vector<std::string>& written, MergedScanConfig& merged) {
  ScheduleSettings& schedule = merged.schedule;
  read_policy(yaml, written, merged);
  if (const auto v = yaml.find("deadline")) schedule.deadline = v->duration(0, longest_wait_s);
  if (const auto v = yaml.find("max_age")) schedule.max_age = v->duration(0.001, longest_wait_s);
  if (const auto v = yaml.find("lost_after")) schedule.lost_after = v->duration(0.001, longest_wait_s);
  if (const auto v = yaml.find("publish_when_empty")) schedule.publish_when_empty = v->boolean();
  if (const auto v = yaml.find("on_missing_motion")) merged.on_missing_motion = read_word(*v, motions);
}

void read_source_settings(Mapping& yaml, const std::vector<std::string>& written, MergedScanConfig& merged) {
  const auto section = yaml.find("source_settings");
  if (!section) return;
  SourceSettings common;
  common.noise = merged.range_noise;
  common.echoes = merged.echoes;
  common.veil_filter = merged.veil_filter;
  const auto& sources = merged.laserscan_topics;
  std::vector<std::string_view> names(sources.begin(), sources.end());
  names.insert(names.end(), written.begin(), written.end());
  Mapping entries(*section, names);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto entry = entries.find(names[i]);
    const std::string& source = sources[i % sources.size()];
    if (!entry || (i >= sources.size() && names[i] == source)) continue;
    if (merged.source_settings.count(source) != 0)
      entry->fail_at_key("is " + source + ", which has settings already", "one entry for each source");
    merged.source_settings[source] = read_one_source(*entry, common);
  }
}

}  // namespace lidard
