// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/pose.h"
#include "core/merge/scheduler.h"
#include "drivers/key.h"

namespace lidard {

class Mapping;
struct Reading;
struct SourceList;

/// What a merged scan or cloud does while poses of the vehicle are missing: as if it stood, wait for them as
/// long as for a source, or leave the output out.
enum class MissingMotion : std::uint8_t { stand, wait, drop };

/// Keys of ScheduleSettings, for policy and for patience.
Keys<ScheduleSettings> policy_keys();
Keys<ScheduleSettings> patience_keys();
constexpr const char* trigger_form = "the source whose sweeps trigger the output";
/// When a merged scan or cloud is published. `trigger`: the name of its triggering source.
template <class Merged>
Keys<Merged> schedule_keys(KeyValue (*trigger)(const Merged&)) {
  const Form motion = keys::word(
      {{"static", MissingMotion::stand}, {"wait", MissingMotion::wait}, {"drop", MissingMotion::drop}});
  return {
      within(&Merged::schedule, policy_keys()),
      Keys<Merged>{{"trigger", trigger, keys::special(trigger_form),
                    "the source whose sweeps trigger the output, with policy trigger"}},
      within(&Merged::schedule, patience_keys()),
      Keys<Merged>{{"on_missing_motion", &Merged::on_missing_motion, motion,
                    "while poses of the vehicle are missing: as if it stood, wait for them, or no output"}}};
}
/// Name of the triggering source, for the getter of that key.
inline KeyValue name_of_trigger(const ScheduleSettings& schedule, const std::vector<std::string>& sources) {
  return schedule.trigger < sources.size() ? KeyValue(sources[schedule.trigger]) : KeyValue();
}
/// A rate and a trigger belong to the policy of that name.
inline bool applies(const Key& key, const ScheduleSettings& schedule) {
  return (key.name != "rate" || schedule.policy == Policy::rate) &&
         (key.name != "trigger" || schedule.policy == Policy::trigger);
}
void check_schedule(const Mapping& yaml, const SourceList& list, ScheduleSettings& schedule);
/// The pose of a destination that is base_frame itself is known.
void check_destination(const Mapping& yaml, const std::string& frame, std::optional<Pose>& pose,
                       Reading& reading);

}  // namespace lidard
