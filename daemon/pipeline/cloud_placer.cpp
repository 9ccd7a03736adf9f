// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/cloud_placer.h"

#include <algorithm>

namespace lidard {
namespace {

constexpr Span longest_wait = std::chrono::milliseconds(200);
// Packets are much more frequent than poses.
constexpr Span between_tries = std::chrono::milliseconds(5);
// Clouds of longest_wait at 20 revolutions/s.
constexpr std::size_t most_waiting = 4;

}  // namespace

void CloudPlacer::add(const Cloud& cloud, Stamp now) {
  if (waiting_ == most_waiting) release_first(now);
  if (waiting_ == clouds_.size()) clouds_.emplace_back();
  clouds_[waiting_].cloud = cloud;
  clouds_[waiting_].instant = arranger_.stamp_of(cloud);
  clouds_[waiting_].since = now;
  ++waiting_;
  release_due(now);
}

void CloudPlacer::advance(Stamp now) {
  const bool too_soon = now >= last_try_ && now - last_try_ < between_tries;
  if (waiting_ > 0 && !too_soon) release_due(now);
}

std::optional<Stamp> CloudPlacer::next_event() const {
  return waiting_ > 0 ? std::optional(last_try_ + between_tries) : std::nullopt;
}

void CloudPlacer::release_due(Stamp now) {
  last_try_ = now;
  context_.motion.poll(now);
  while (waiting_ > 0) {
    const bool may_wait = PoseGate::may_wait(clouds_.front().since, longest_wait, now);
    if (!release(clouds_.front(), may_wait, now)) return;
    drop_first();
  }
}

void CloudPlacer::finish(Stamp now) {
  while (waiting_ > 0) release_first(now);
}

void CloudPlacer::release_first(Stamp now) {
  release(clouds_.front(), false, now);
  drop_first();
}

void CloudPlacer::drop_first() {
  const auto end = clouds_.begin() + static_cast<std::ptrdiff_t>(waiting_);
  std::rotate(clouds_.begin(), clouds_.begin() + 1, end);
  --waiting_;
}

bool CloudPlacer::find_motion(const Cloud& cloud, Stamp instant) {
  const PoseTrack* const track = context_.motion.track();
  Pose vehicle_from_cloud;
  std::string why_not;
  return track != nullptr &&
         context_.frames.find(context_.vehicle.base_frame, cloud.frame_id, instant, vehicle_from_cloud,
                              why_not) &&
         motion_.find(cloud, vehicle_from_cloud, *track, instant);
}

bool CloudPlacer::release(Waiting& waiting, bool may_wait, Stamp now) {
  Cloud& cloud = waiting.cloud;
  const std::string& frame = sensor_.points_frame.empty() ? cloud.frame_id : sensor_.points_frame;
  Pose frame_from_lidar = Pose::Identity();
  std::string why_not;
  const bool is_placed =
      context_.frames.find(frame, cloud.frame_id, waiting.instant, frame_from_lidar, why_not);
  const bool is_deskewed = is_placed && (!sensor_.deskew || find_motion(cloud, waiting.instant));
  if (!is_deskewed && may_wait) return false;
  if (!is_placed) {
    gate_.left_out(why_not);
    return true;
  }
  gate_.published(is_deskewed);
  const CloudMotion& motion = sensor_.deskew && is_deskewed ? motion_ : stands_;
  // Points that do not move stay bit-identical.
  if (!motion.stands() || frame != cloud.frame_id) move_points(motion, frame_from_lidar, cloud);
  cloud.frame_id = frame;
  topic_.deliver(arranger_.message_of(cloud), now);
  return true;
}

}  // namespace lidard
