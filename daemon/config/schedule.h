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

constexpr const char* trigger_form = "the source whose sweeps trigger the output";
/// When a merged scan or cloud is published. A rate and a trigger, one of `sources`, apply with the policy of
/// that name.
Keys schedule_keys(ScheduleSettings& schedule, MissingMotion& motion,
                   const std::vector<std::string>& sources);
void check_schedule(const Mapping& yaml, const SourceList& list, ScheduleSettings& schedule);
/// The pose of a destination that is base_frame itself is known.
void check_destination(const Mapping& yaml, const std::string& frame, std::optional<Pose>& pose,
                       Reading& reading);

}  // namespace lidard
