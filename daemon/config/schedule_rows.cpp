// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The keys that merged scans and merged clouds share: when one is published.
#include <algorithm>

#include "daemon/config/sections.h"

namespace lidard {
namespace {

using namespace keys;

constexpr double longest_wait_s = 3600;
constexpr double most_outputs_per_s = 1000;

/// Index of the source that `value` names: as it is named in the list, or by its own name.
std::size_t index_of_source(const Value& value, const SourceList& list) {
  std::string expected = "one of " + std::string(list.key) + ":";
  for (const std::string& source : list.names) expected += " " + source;
  const std::string name = value.text(expected);
  auto found = std::find(list.names.begin(), list.names.end(), name);
  if (found == list.names.end())
    found = list.names.begin() +
            (std::find(list.written.begin(), list.written.end(), name) - list.written.begin());
  if (found == list.names.end()) value.fail("is " + value.quoted() + ", which is no source of it", expected);
  return static_cast<std::size_t>(found - list.names.begin());
}

}  // namespace

SourceList read_sources(const Mapping& yaml, std::string_view key, const std::string& expected,
                        FrameKind (*kind_of)(const Value&, const Config&), Reading& reading) {
  SourceList list{key, {}, {}, {}, {}};
  const Value all = yaml.require(key, expected);
  list.values = all.names(expected);
  if (list.values.empty()) all.fail("names nothing", expected);
  Mistakes mistakes;
  for (const Value& value : list.values) {
    mistakes.attempt([&] {
      const FrameKind kind = kind_of(value, reading.config);
      const NamedSource source = read_source(value, kind, reading, expected);
      if (source.merged_cloud != nullptr)
        value.fail("names " + value.quoted() + ", a merged cloud", expected);
      if (std::find(list.names.begin(), list.names.end(), source.name) != list.names.end())
        value.fail("names " + source.name + " again", "every source once");
      if (source.sensor != nullptr) reading.claims.uses(*source.sensor, kind, yaml.self().path(), value);
      list.names.push_back(source.name);
      list.written.push_back(value.text());
      list.named.push_back(source);
    });
  }
  mistakes.throw_if_any();
  return list;
}

Keys<ScheduleSettings> policy_rows() {
  using S = ScheduleSettings;
  const Words<Policy> policies{
      {"complete", Policy::complete}, {"rate", Policy::rate}, {"trigger", Policy::trigger}};
  return {
      word("policy", &S::policy, policies,
           "published with each sweep of the slowest source, at a rate, or when one has delivered"),
      number("rate", &S::rate, 0.01, most_outputs_per_s, "1/s", "with policy rate").shown_if([](const S& s) {
        return s.policy == Policy::rate;
      })};
}

Keys<ScheduleSettings> patience_rows() {
  using S = ScheduleSettings;
  return {number("deadline", &S::deadline, 0, longest_wait_s, "s",
                 "how late a source may be before an output is published without it")
              .unless_set("0.3 of the shortest period of the sources"),
          number("lost_after", &S::lost_after, 0.001, longest_wait_s, "s",
                 "silence after which a source is lost, which is an ERROR")};
}

void check_policy(Mapping& yaml, const SourceList& list, ScheduleSettings& schedule) {
  const bool is_open = !yaml.has("policy");
  const auto need = [&](const Value& key, Policy policy) {
    if (is_open) schedule.policy = policy;
    const std::string wanted = std::string("policy: ") + to_string(policy);
    if (schedule.policy != policy)
      key.fail_at_key(std::string("has no effect with policy: ") + to_string(schedule.policy), wanted);
  };
  if (const auto rate = yaml.find("rate")) need(*rate, Policy::rate);
  if (const auto trigger = yaml.find("trigger")) {
    schedule.trigger = index_of_source(*trigger, list);
    need(*trigger, Policy::trigger);
  } else if (schedule.policy == Policy::trigger) {
    yaml.require("trigger", trigger_form);
  }
}

void check_destination(const Mapping& yaml, const std::string& frame, std::optional<Pose>& pose,
                       Reading& reading) {
  const std::string& base = reading.config.vehicle.base_frame;
  if (pose)
    reading.claims.holds_frame(frame, base, *pose, yaml.self().path(), yaml.where("destination_pose"));
  else if (frame == base)
    pose = Pose::Identity();
}

}  // namespace lidard
