// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/output_health.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/health/sentences.h"

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

/// Why inputs have no pose; empty: none has lacked it lately.
std::string why_no_pose(const MakerCounters& counters, Stamp now) {
  const bool lasts = counters.no_pose > 0 && seconds(now - counters.no_pose_at) <= counters.most_silence;
  return lasts ? counters.why_no_pose : "";
}

/// Whether an output publishes, and if not, why.
void judge_output(const MakerStatus& status, Stamp now, DiagnosticItem& item) {
  const MakerCounters& counters = status.counters;
  const double age = seconds(now - counters.last_published);
  const std::string why = why_no_pose(counters, now);
  if (status.starting && why.empty() && (counters.published == 0 || age > counters.most_silence)) {
    item.set<says::waiting_for_input>();
  } else if (counters.published > 0 && age <= counters.most_silence) {
    item.set<says::publishing>();
  } else if (!why.empty()) {
    counters.published == 0 ? item.set<says::no_output>(why) : item.set<says::no_output_any_more>(why);
  } else {
    counters.published == 0 ? item.set<says::no_input>()
                            : item.set<says::output_stopped>(counters.most_silence);
  }
  item.awaited = counters.published == 0;
  item.add("Published", counters.published);
  item.add("Held back without a newer instant", counters.held_back);
  item.add("Inputs without pose", counters.no_pose);
}

std::string source_text(const SourceStatus& source) {
  std::string state = to_string(source.state);
  if (source.state == SourceState::never) return state;
  return text<says::source_state>(state, source.period_s > 0 ? 1 / source.period_s : 0, source.age_s * 1000);
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

/// s; the deadline that would wait for stale sources; 0: none, since a source follows another clock.
double better_deadline(const MergeStatus& merge) {
  constexpr double longest_said_s = 1, room_s = 0.02;
  double deadline = 0;
  for (const SourceStatus& source : merge.sources) {
    if (source.lasting == SourceState::stale && source.late_s > 0 && source.late_s < longest_said_s)
      deadline = source.late_s + room_s;
  }
  return deadline;
}

void judge_sources(const MakerStatus& status, const MergeStatus& merge, Stamp now, DiagnosticItem& item) {
  for (const SourceStatus& source : merge.sources) item.add("Source " + source.name, source_text(source));
  const std::string stale = names_of(merge, true), lost = names_of(merge, false);
  item.add("Sources lost", lost);
  if (status.starting || item.health != Health::ok) return;
  if (merge.apart > another_clock) item.set<says::clocks_apart>(seconds(merge.apart));
  if (lost.empty() && stale.empty()) return;
  const auto is = [&](SourceState state) {
    return std::any_of(merge.sources.begin(), merge.sources.end(),
                       [&](const SourceStatus& source) { return source.lasting == state; });
  };
  item.awaited = !is(SourceState::lost);
  const std::string why = why_no_pose(status.counters, now);
  const double deadline = better_deadline(merge);
  if (!is(SourceState::ok))
    why.empty() ? item.set<says::no_source>() : item.set<says::no_source_because>(why);
  else if (!lost.empty())
    why.empty() ? item.set<says::sources_lost>(lost) : item.set<says::published_without>(lost, why);
  else
    deadline > 0 ? item.set<says::sources_late>(stale, deadline) : item.set<says::sources_old>(stale);
  item.health = lost.empty() ? Health::warn : Health::error;
}

void judge_merge(const MakerStatus& status, const MergeStatus& merge, Stamp now, DiagnosticItem& item) {
  judge_sources(status, merge, now, item);
  if (merge.track != nullptr) {
    const auto has = [&](SourceUse use) { return std::count(merge.uses.begin(), merge.uses.end(), use) > 0; };
    item.add("Motion", merge.track->empty()           ? text<says::track_empty>()
                       : has(SourceUse::static_poses) ? text<says::track_too_short>()
                       : has(SourceUse::extrapolated) ? text<says::track_extrapolated>()
                                                      : text<says::track_complete>());
    add_pose_gate(merge.gate, {}, item);
  }
  item.add("Sources waited for in vain", merge.deadlines_missed);
  if (const std::string trouble = pose_trouble(merge.gate);
      status.counters.published == 0 && !trouble.empty())
    item.message = text<says::no_output>(trouble);
}

/// What to add to the pose of the pair's second source, in the output frame; `sign` -1: to that of the first.
std::string correction_of(const MountDifference& pair, double sign) {
  const auto part = [&](std::size_t i, const char* name, double scale, const char* unit) {
    const auto at = static_cast<Eigen::Index>(i);
    return pair.determined[i] ? text<says::correction>(name, sign * scale * pair.correction[at], unit)
                              : text<says::undetermined>(name);
  };
  return part(2, "yaw", deg_per_rad, "deg") + ", " + part(0, "x", 1, "m") + ", " + part(1, "y", 1, "m");
}

std::tm utc(Stamp stamp) { return fmt::gmtime(stamp.ns / 1'000'000'000); }

void judge_mounts(const MergeStatus& merge, DiagnosticItem& item) {
  const auto wrong = merge.wrong_mount;
  for (const MountDifference& pair : merge.mounts) {
    const std::string& first = merge.sources[pair.first].name;
    const std::string& second = merge.sources[pair.second].name;
    const bool is_first = wrong == pair.first;
    const std::string& its = is_first ? first : second;
    if (pair.is_astray && item.health == Health::ok)
      item.set<says::nothing_in_common>(its, is_first ? second : first, wrong ? its : text<says::both>(),
                                        utc(*pair.astray_since));
    if (pair.surfaces == 0) continue;
    item.add(fmt::format("Mount check {}/{}", first, second),
             text<says::mount_check>(pair.surfaces, second, correction_of(pair, 1),
                                     1000 * pair.sigma.head<2>().maxCoeff(), deg_per_rad * pair.sigma[2]));
    if (pair.is_wrong && item.health == Health::ok)
      item.set<says::mount_wrong>(first, second,
                                  wrong ? text<says::the_mount>(its) : text<says::a_mount>(its),
                                  correction_of(pair, is_first ? -1 : 1), utc(*pair.since));
  }
}

void judge_planes(const VirtualStatus& planes, DiagnosticItem& item) {
  for (std::size_t i = 0; i < planes.frames.size() && item.health == Health::ok; ++i) {
    if (!planes.why_unplaced[i].empty())
      item.set<says::published_without>(planes.frames[i], planes.why_unplaced[i]);
  }
  if (planes.gate) add_pose_gate(*planes.gate, {}, item);
  if (item.health == Health::ok && !planes.why_no_surfaces.empty())
    item.set<says::points_alone>(planes.why_no_surfaces);
}

/// The fault, with the remedy; empty: none.
std::string motion_trouble(const MotionStatus& status) {
  if (!status.has_poses) return text<says::no_pose_yet>();
  if (status.clock_ahead)
    return clock_trouble(text<says::from_topic>(status.topic), *status.clock_ahead, false);
  if (!status.data_live) return status.poses_live ? "" : text<says::no_pose_any_more>();
  if (status.data_ahead_s.value_or(0) > longest_lag_s) return text<says::poses_late>(*status.data_ahead_s);
  if (status.poses_ahead_s.value_or(0) > longest_lag_s) return text<says::poses_early>(*status.poses_ahead_s);
  return "";
}

}  // namespace

DiagnosticItem output_health(const MakerStatus& status, Stamp now) {
  DiagnosticItem item{name_of(status.id)};
  judge_output(status, now, item);
  if (status.merge) {
    judge_merge(status, *status.merge, now, item);
    judge_mounts(*status.merge, item);
  }
  if (status.planes) judge_planes(*status.planes, item);
  if (item.health == Health::ok && status.counters.published > 0 && !status.is_wanted)
    item.set<says::not_built>(status.topics.front());
  for (const auto& [name, count] : status.figures) item.add(name, count);
  return item;
}

DiagnosticItem motion_health(const MotionStatus& status) {
  DiagnosticItem item{"motion"};
  const std::string what = motion_trouble(status);
  const std::string why = status.lacks_speed ? text<says::no_speed>(status.speed_topic) : status.why_refused;
  if (what.empty())
    item.set<says::poses_come>();
  else
    item.set(Health::warn, why.empty() ? what : text<says::pose_refused>(what, why));
  item.add("Knots", status.knots);
  item.add("Jumps back", status.jumps_back);
  item.add("Not rigid", status.not_rigid);
  item.add("Frame not known", status.refused);
  if (!status.speed_topic.empty()) item.add("Turn rates without speed", status.without_speed);
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
      return text<says::as_if_it_stood>();
    case PoseGate::Newest::left_out:
      return gate.why().empty() ? text<says::dropped_for_poses>()
                                : text<says::not_in_frame>(frame, gate.why());
  }
  return {};
}

std::string pose_losses(const PoseGate& gate, const std::string& frame) {
  const std::uint64_t left_out = gate.left_out_count(), standing = gate.not_deskewed_count();
  const auto plural = [](std::uint64_t count) { return count == 1 ? "" : "s"; };
  std::string losses;
  if (left_out > 0) losses = text<says::clouds_left_out>(left_out, plural(left_out));
  if (standing > 0)
    losses += (losses.empty() ? "" : ", ") + text<says::clouds_not_deskewed>(standing, plural(standing));
  const std::string trouble = pose_trouble(gate, frame);
  return losses.empty() || trouble.empty() ? losses : losses + "; " + trouble;
}

void add_pose_gate(const PoseGate& gate, const std::string& frame, DiagnosticItem& item) {
  item.add("Not deskewed", gate.not_deskewed_count());
  item.add("Left out without poses", gate.left_out_count());
  if (std::string trouble = pose_trouble(gate, frame); item.health == Health::ok && !trouble.empty())
    item.set(Health::warn, std::move(trouble));
}

std::string clock_trouble(const std::string& source, Span ahead, bool has_offset) {
  const double s = seconds(ahead);
  return text<says::stamps_replaced>(source, std::abs(s),
                                     s > 0 ? text<says::ahead_of>() : text<says::behind>(),
                                     has_offset ? text<says::or_offset>(-s) : "");
}

}  // namespace lidard
