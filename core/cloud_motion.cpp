// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/cloud_motion.h"

#include <algorithm>

namespace lidard {
namespace {

// Within that time a vehicle moves by less than a millimetre.
constexpr Span group = std::chrono::microseconds(250);

}  // namespace

/// The motion of a return at `stamp`; returns of nearly the same time share it.
const Pose& CloudMotion::at(Stamp stamp) {
  const Span off = stamp - newest_at_;
  if (off < group && off > -group) return newest_;
  Pose odom_from_vehicle;
  if (track_->at(stamp, odom_from_vehicle) == PoseOrigin::missing) return newest_;
  newest_at_ = stamp;
  newest_ = now_from_odom_ * odom_from_vehicle * vehicle_from_cloud_;
  return newest_;
}

bool CloudMotion::find(const Cloud& cloud, const Pose& vehicle_from_cloud, const PoseTrack& track) {
  columns_.clear();
  if (track.empty()) return false;
  instant_ = std::max(cloud.stamp, std::min(cloud.end, track.newest()));
  Pose odom_from_vehicle;
  if (!track.covers(cloud.stamp, cloud.end) || track.at(instant_, odom_from_vehicle) == PoseOrigin::missing)
    return false;
  track_ = &track;
  vehicle_from_cloud_ = vehicle_from_cloud;
  now_from_odom_ = (odom_from_vehicle * vehicle_from_cloud).inverse();
  newest_at_ = instant_;
  newest_ = Pose::Identity();
  for (const CloudColumn& column : cloud.columns) columns_.push_back(at(column.stamp));
  return true;
}

const Cloud& CloudMotion::moved(const Cloud& cloud) {
  if (!cloud.columns.empty()) return cloud;
  copy_ = cloud;
  for (std::size_t i = 0; i < copy_.size(); ++i) {
    CloudPoint& point = copy_.points()[i];
    const Pose& move = at(cloud.stamp + span_from_seconds(static_cast<double>(point.time)));
    const Eigen::Vector3d p =
        move * Eigen::Vector3d(static_cast<double>(point.x), static_cast<double>(point.y),
                               static_cast<double>(point.z));
    point.x = static_cast<float>(p.x());
    point.y = static_cast<float>(p.y());
    point.z = static_cast<float>(p.z());
  }
  return copy_;
}

}  // namespace lidard
