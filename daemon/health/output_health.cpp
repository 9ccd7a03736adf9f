// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/output_health.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace lidard {
namespace {

std::string name_of(const MakerId& id) {
  switch (id.kind) {
    case MakerId::Kind::merged:
      return "merged " + id.entry;
    case MakerId::Kind::merged_cloud:
      return "merged cloud " + id.entry;
    case MakerId::Kind::virtual_group:
      return "virtual " + id.entry;
  }
  return id.entry;
}

/// Whether an output publishes, and if not, why.
void judge_output(const MakerStatus& status, Stamp now, DiagnosticItem& item) {
  const MakerCounters& counters = status.counters;
  const double age = seconds(now - counters.last_published);
  if (status.starting && counters.no_pose == 0 && (counters.published == 0 || age > counters.most_silence)) {
    item.message = "waiting for input";
  } else if (counters.published == 0) {
    item.set(Health::error, counters.no_pose > 0 ? "no output: " + counters.why_no_pose
                                                 : "no output: no input has come in yet");
  } else if (age > counters.most_silence) {
    item.set(Health::error,
             counters.no_pose > 0
                 ? "no output any more: " + counters.why_no_pose
                 : fmt::format("no output for more than {:.0f} s: see the state of its sensors",
                               counters.most_silence));
  } else {
    item.message = "publishing";
  }
  item.awaited = counters.published == 0;
  item.add("Published", counters.published);
  item.add("Held back without a newer instant", counters.held_back);
  item.add("Inputs without pose", counters.no_pose);
}

std::string source_text(const SourceStatus& source) {
  const std::string state = to_string(source.state);
  if (source.state == SourceState::never) return state;
  return state + fmt::format(", {:.1f} Hz, age {:.0f} ms", source.period_s > 0 ? 1 / source.period_s : 0,
                             source.age_s * 1000);
}

/// The names of the sources in that lasting state or, for `lost`, worse than stale.
std::string names_of(const MergeStatus& merge, bool stale) {
  std::string names;
  for (const SourceStatus& source : merge.sources) {
    if (source.lasting == SourceState::ok || (source.lasting == SourceState::stale) != stale) continue;
    names += (names.empty() ? "" : ", ") + source.name;
  }
  return names;
}

/// The deadline that would wait for stale sources; empty: that of a source that follows another clock.
std::string deadline_remedy(const MergeStatus& merge) {
  constexpr double longest_said_s = 1, room_s = 0.02;
  std::string remedy;
  for (const SourceStatus& source : merge.sources) {
    if (source.lasting == SourceState::stale && source.late_s > 0 && source.late_s < longest_said_s)
      remedy = fmt::format("; a deadline of {:.2f} waits for them", source.late_s + room_s);
  }
  return remedy;
}

void judge_sources(const MakerStatus& status, const MergeStatus& merge, DiagnosticItem& item) {
  for (const SourceStatus& source : merge.sources) item.add("Source " + source.name, source_text(source));
  const std::string stale = names_of(merge, true), lost = names_of(merge, false);
  item.add("Sources lost", lost);
  if (status.starting || item.health != Health::ok) return;
  if (merge.apart > another_clock)
    item.set(Health::warn, fmt::format("merges scans whose stamps are {:.0f} s apart; let all sources follow "
                                       "one clock, a simulator's (/use_sim_time) or this computer's",
                                       seconds(merge.apart)));
  if (lost.empty() && stale.empty()) return;
  item.set(lost.empty() ? Health::warn : Health::error,
           "publishing without " +
               (lost.empty() ? stale + ", whose sweeps are too old" + deadline_remedy(merge) : lost));
  const auto is = [&](SourceState state) {
    return std::any_of(merge.sources.begin(), merge.sources.end(),
                       [&](const SourceStatus& source) { return source.lasting == state; });
  };
  if (!is(SourceState::ok))
    item.message = "no output, since no source delivers: see the state of its sensors";
  item.awaited = !is(SourceState::lost);
  const MakerCounters& counters = status.counters;
  if (counters.no_pose > 0 && !counters.why_no_pose.empty()) item.message += ": " + counters.why_no_pose;
}

void judge_merge(const MakerStatus& status, const MergeStatus& merge, DiagnosticItem& item) {
  judge_sources(status, merge, item);
  if (merge.track != nullptr) {
    const auto has = [&](SourceUse use) { return std::count(merge.uses.begin(), merge.uses.end(), use) > 0; };
    item.add("Motion", merge.track->empty()           ? "no poses yet"
                       : has(SourceUse::static_poses) ? "not deskewed: poses of the sweeps' time are missing"
                       : has(SourceUse::extrapolated) ? "deskewed, partly beyond the newest pose"
                                                      : "deskewed");
    add_pose_gate(merge.gate, {}, item);
  }
  item.add("Sources waited for in vain", merge.deadlines_missed);
  if (const std::string trouble = pose_trouble(merge.gate);
      status.counters.published == 0 && !trouble.empty())
    item.message = "no output: " + trouble;
}

/// What to add to the pose of the pair's second source, in the output frame; `sign` -1: to that of the first.
std::string correction_of(const MountDifference& pair, double sign) {
  const auto part = [&](std::size_t i, const char* name, double scale, const char* unit) {
    const auto at = static_cast<Eigen::Index>(i);
    return pair.determined[i] ? fmt::format("{} {:+.3f} {}", name, sign * scale * pair.correction[at], unit)
                              : fmt::format("{} not determined by the surroundings", name);
  };
  return part(2, "yaw", deg_per_rad, "deg") + ", " + part(0, "x", 1, "m") + ", " + part(1, "y", 1, "m");
}

void judge_mounts(const MergeStatus& merge, DiagnosticItem& item) {
  const auto wrong = merge.wrong_mount;
  for (const MountDifference& pair : merge.mounts) {
    const std::string& first = merge.sources[pair.first].name;
    const std::string& second = merge.sources[pair.second].name;
    const bool is_first = wrong == pair.first;
    if (pair.is_astray && item.health == Health::ok)
      item.set(
          Health::warn,
          fmt::format("{} sees nothing of what {} sees where their fields of view overlap; check the pose "
                      "of {} (since {:%H:%M:%S} UTC; `lidard calibrate -c FILE CAPTURE` of the parked "
                      "vehicle finds it)",
                      is_first ? first : second, is_first ? second : first,
                      wrong ? (is_first ? first : second) : "both",
                      fmt::gmtime(pair.astray_since->ns / 1'000'000'000)));
    if (pair.surfaces == 0) continue;
    item.add(fmt::format("Mount check {}/{}", first, second),
             fmt::format("{} surfaces; mount of {}: {}; +- {:.1f} mm, {:.3f} deg", pair.surfaces, second,
                         correction_of(pair, 1), 1000 * pair.sigma.head<2>().maxCoeff(),
                         deg_per_rad * pair.sigma[2]));
    if (!pair.is_wrong || item.health != Health::ok) continue;
    item.set(Health::warn,
             fmt::format(
                 "{} and {} do not agree on where surfaces are; correct {} {} by {} (since {:%H:%M:%S} "
                 "UTC; `lidard calibrate -c FILE CAPTURE` of the parked vehicle finds it)",
                 first, second, wrong ? "the mount of" : "a mount, e.g. that of", is_first ? first : second,
                 correction_of(pair, is_first ? -1 : 1), fmt::gmtime(pair.since->ns / 1'000'000'000)));
  }
}

void judge_planes(const VirtualStatus& planes, DiagnosticItem& item) {
  for (std::size_t i = 0; i < planes.frames.size() && item.health == Health::ok; ++i) {
    if (!planes.why_unplaced[i].empty())
      item.set(Health::warn, "publishing without " + planes.frames[i] + ": " + planes.why_unplaced[i]);
  }
  if (planes.gate) add_pose_gate(*planes.gate, {}, item);
  if (item.health == Health::ok && !planes.why_no_surfaces.empty())
    item.set(Health::warn,
             "points alone, nothing is known to be free: of the cloud " + planes.why_no_surfaces);
}

/// The fault, with the remedy; empty: none.
std::string motion_trouble(const MotionStatus& status) {
  if (!status.has_poses)
    return "no pose of the vehicle yet, so scans are not deskewed; see that odometry is published";
  if (status.clock_ahead) return clock_trouble("topic " + status.topic, *status.clock_ahead, false);
  if (!status.data_live) return status.poses_live ? "" : "no pose of the vehicle any more";
  if (status.data_ahead_s.value_or(0) > longest_lag_s)
    return fmt::format(
        "the newest pose of the vehicle is {:.1f} s older than the newest scan, which is not deskewed; does "
        "odometry still come, and are its stamps of the same clock?",
        *status.data_ahead_s);
  if (status.poses_ahead_s.value_or(0) > longest_lag_s)
    return fmt::format(
        "the oldest pose of the vehicle is {:.1f} s newer than the newest scan, which is not deskewed; are "
        "the stamps of both of the same clock?",
        *status.poses_ahead_s);
  return "";
}

}  // namespace

DiagnosticItem output_health(const MakerStatus& status, Stamp now) {
  DiagnosticItem item{name_of(status.id)};
  judge_output(status, now, item);
  if (status.merge) {
    judge_merge(status, *status.merge, item);
    judge_mounts(*status.merge, item);
  }
  if (status.planes) judge_planes(*status.planes, item);
  if (item.health == Health::ok && status.counters.published > 0 && !status.is_wanted)
    item.message =
        "not built: nobody subscribes to " + status.topics.front() + ", and no virtual scan is made of it";
  for (const auto& [name, count] : status.figures) item.add(name, count);
  return item;
}

DiagnosticItem motion_health(const MotionStatus& status) {
  DiagnosticItem item{"motion"};
  const std::string what = motion_trouble(status);
  item.set(what.empty() ? Health::ok : Health::warn, what.empty() ? "poses come in" : what);
  if (!what.empty() && !status.why_refused.empty()) item.message += ": " + status.why_refused;
  item.add("Knots", status.knots);
  item.add("Jumps back", status.jumps_back);
  item.add("Not rigid", status.not_rigid);
  item.add("Frame not known", status.refused);
  if (status.has_speed_topic) item.add("Turn rates without speed", status.without_speed);
  if (status.data_ahead_s) item.add("Scans ahead of poses (s)", std::to_string(*status.data_ahead_s));
  item.add("Stamps replaced", status.stamps_replaced);
  item.add("Out of order", status.out_of_order);
  return item;
}

std::string pose_trouble(const PoseGate& gate, const std::string& frame) {
  switch (gate.newest()) {
    case PoseGate::Newest::published:
      return {};
    case PoseGate::Newest::not_deskewed:
      return "published as if the vehicle stood still: its poses at the time of measuring are missing; see "
             "that odometry is published";
    case PoseGate::Newest::left_out:
      return gate.why().empty() ? "on_missing_motion: drop, and poses of the vehicle are missing"
                                : "not published in " + frame + ": " + gate.why();
  }
  return {};
}

std::string pose_losses(const PoseGate& gate, const std::string& frame) {
  std::string text;
  for (const auto& [count, what] :
       {std::pair(gate.left_out_count(), "not published"), {gate.not_deskewed_count(), "not deskewed"}}) {
    if (count > 0)
      text +=
          fmt::format("{}{} {} {}", text.empty() ? "" : ", ", count, count == 1 ? "cloud" : "clouds", what);
  }
  const std::string trouble = pose_trouble(gate, frame);
  return text.empty() || trouble.empty() ? text : text + "; " + trouble;
}

void add_pose_gate(const PoseGate& gate, const std::string& frame, DiagnosticItem& item) {
  item.add("Not deskewed", gate.not_deskewed_count());
  item.add("Left out for want of poses", gate.left_out_count());
  if (std::string trouble = pose_trouble(gate, frame); item.health == Health::ok && !trouble.empty())
    item.set(Health::warn, std::move(trouble));
}

std::string clock_trouble(const std::string& source, Span ahead, bool has_offset) {
  const double s = seconds(ahead);
  return fmt::format(
      "the stamps of {} are {:.2f} s {} this computer's clock, so they are placed by their arrival; "
      "synchronise the clocks of both computers (chrony){}; of a bag or a simulator, set /use_sim_time",
      source, std::abs(s), s > 0 ? "ahead of" : "behind",
      has_offset ? fmt::format(" or set time_offset: {:.3f}", -s) : "");
}

}  // namespace lidard
