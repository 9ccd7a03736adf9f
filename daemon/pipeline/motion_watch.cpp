// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/motion_watch.h"

#include <spdlog/fmt/fmt.h>

namespace lidard {
namespace {

constexpr double longest_lag_s = 0.5;
constexpr double data_live_s = 1;

}  // namespace

void MotionWatch::data(Stamp stamp, Stamp now) { data_ = Newest{stamp, now}; }

void MotionWatch::poses(const PoseTrack& track, Stamp now) {
  if (track.empty() || (pose_ && pose_->stamp == track.newest())) return;
  pose_ = Newest{track.newest(), now};
}

std::optional<double> MotionWatch::lag(const PoseTrack& track) const {
  if (track.empty() || !data_) return std::nullopt;
  return seconds(data_->stamp - track.newest());
}

std::string MotionWatch::trouble(const PoseTrack& track, Stamp now) const {
  if (track.empty()) return "no pose of the vehicle yet; scans are not deskewed";
  const bool data_live = data_ && seconds(now - data_->arrival) < data_live_s;
  if (!data_live) {
    const bool pose_live = pose_ && seconds(now - pose_->arrival) < longest_lag_s;
    return pose_live ? "" : "no pose of the vehicle any more";
  }
  const double lag = seconds(data_->stamp - track.newest());
  if (lag > longest_lag_s)
    return fmt::format(
        "the newest pose of the vehicle is {:.1f} s older than the newest scan, which is not deskewed; does "
        "odometry still come, and are its stamps of the same clock?",
        lag);
  const double ahead = seconds(track.oldest() - data_->stamp);
  if (ahead > longest_lag_s)
    return fmt::format(
        "the oldest pose of the vehicle is {:.1f} s newer than the newest scan, which is not deskewed; are "
        "the stamps of both of the same clock?",
        ahead);
  return "";
}

DiagnosticItem MotionWatch::diagnostics(const PoseTrack& track, std::uint64_t refused, const std::string& why,
                                        Stamp now) const {
  DiagnosticItem item;
  item.name = "motion";
  const std::string what = trouble(track, now);
  item.health = what.empty() ? Health::ok : Health::warn;
  item.message = what.empty() ? "poses come in" : what;
  if (!what.empty() && refused > 0) item.message += ": " + why;
  item.values = {{"Knots", std::to_string(track.size())},
                 {"Jumps back", std::to_string(track.restarts())},
                 {"Not rigid", std::to_string(track.not_rigid())},
                 {"Frame not known", std::to_string(refused)}};
  if (const auto behind = lag(track))
    item.values.emplace_back("Scans ahead of poses (s)", std::to_string(*behind));
  return item;
}

}  // namespace lidard
