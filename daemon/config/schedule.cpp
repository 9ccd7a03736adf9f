// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The keys that merged scans and merged clouds share: when one is published.
#include "daemon/config/schedule.h"

#include "daemon/config/reading.h"
#include "daemon/config/vehicle.h"

namespace lidard {
namespace {

constexpr double longest_wait_s = 3600;
constexpr double most_outputs_per_s = 1000;

}  // namespace

Keys schedule_keys(ScheduleSettings& schedule, MissingMotion& motion,
                   const std::vector<std::string>& sources) {
  using namespace keys;
  const KeyValue trigger =
      schedule.trigger < sources.size() ? KeyValue(sources[schedule.trigger]) : KeyValue();
  return join(
      {{{"policy", schedule.policy,
         word({{"complete", Policy::complete}, {"rate", Policy::rate}, {"trigger", Policy::trigger}}),
         "published with each sweep of the slowest source, at a rate, or when one has delivered"}},
       only_if(schedule.policy == Policy::rate,
               {{"rate", schedule.rate, number(0.01, most_outputs_per_s, "1/s"), "with policy rate"}}),
       only_if(schedule.policy == Policy::trigger,
               {{"trigger", trigger, special(trigger_form),
                 "the source whose sweeps trigger the output, with policy trigger"}}),
       {{"deadline", schedule.deadline, number(0, longest_wait_s, "s"),
         "how late a source may be before an output is published without it",
         remark("0.3 of the shortest period of the sources")},
        {"lost_after", schedule.lost_after, number(0.001, longest_wait_s, "s"),
         "silence after which a source is lost, which is an ERROR"},
        {"on_missing_motion", motion,
         word({{"static", MissingMotion::stand},
               {"wait", MissingMotion::wait},
               {"drop", MissingMotion::drop}}),
         "while poses of the vehicle are missing: as if it stood, wait for them, or no output"}}});
}

void check_schedule(const Mapping& yaml, const SourceList& list, ScheduleSettings& schedule) {
  const bool is_open = !yaml.has("policy");
  const auto need = [&](const Value& key, Policy policy) {
    if (is_open) schedule.policy = policy;
    const std::string wanted = std::string("policy: ") + to_string(policy);
    if (schedule.policy != policy)
      key.fail_at_key(std::string("has no effect with policy: ") + to_string(schedule.policy), wanted);
  };
  if (const auto rate = yaml.find("rate")) need(*rate, Policy::rate);
  if (const auto trigger = yaml.find("trigger")) {
    std::string expected = "one of " + std::string(list.key) + ":";
    for (const std::string& source : list.names) expected += " " + source;
    schedule.trigger = list.index_of(*trigger, expected);
    need(*trigger, Policy::trigger);
  } else if (schedule.policy == Policy::trigger) {
    yaml.require("trigger", trigger_form);
  }
}

void check_destination(const Mapping& yaml, const std::string& frame, std::optional<Pose>& pose,
                       Reading& reading) {
  const std::string& base = reading.vehicle.base_frame;
  if (pose)
    reading.claims.holds_frame(frame, base, *pose, yaml.self().path(), yaml.where("destination_pose"));
  else if (frame == base)
    pose = Pose::Identity();
}

}  // namespace lidard
