// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/frame_motion.h"

#include <cmath>

namespace lidard {
namespace {

constexpr double stretch_s = 1e-3;
constexpr double longest_sweep_s = 10;

std::size_t beams_per_stretch(const SweepTimes& times) {
  if (times.between <= 0) return std::max<std::size_t>(times.beams, 1);
  const double beams = std::floor(stretch_s / times.between);
  return static_cast<std::size_t>(std::clamp(beams, 1.0, static_cast<double>(times.beams)));
}

}  // namespace

SweepTimes times_of(const PlanarScan& scan) {
  return {scan.stamp, static_cast<double>(scan.time_increment), scan.beams};
}

bool has_usable_times(const PlanarScan& scan) {
  const auto between = static_cast<double>(scan.time_increment);
  return between >= 0 && between * static_cast<double>(scan.beams) <= longest_sweep_s;
}

PoseOrigin SweepMotion::follow(const MergeMoment& moment, const SweepTimes& times) {
  stand();
  Pose end;
  if (moment.track == nullptr) return PoseOrigin::missing;
  PoseOrigin worst = moment.track->at(moment.at, end);
  if (worst == PoseOrigin::missing || times.beams == 0) return worst;
  const Pose output_from_odom = moment.output_from_base * end.inverse();
  const Pose base_from_output = moment.output_from_base.inverse();
  step_ = beams_per_stretch(times);
  bool moves = false;
  for (std::size_t beam = 0; beam < times.beams;) {
    Pose pose;
    worst = std::max(worst, moment.track->at(times.at(beam), pose));
    if (worst == PoseOrigin::missing) break;
    Stretch here{beam, beam + 1, Matrix::Identity(), Matrix::Zero()};
    // A vehicle that stands must leave every point where it is to the last bit.
    if (pose.matrix() != end.matrix()) {
      here.from = (output_from_odom * pose * base_from_output).matrix().topRows<3>();
      moves = true;
    }
    if (!stretches_.empty()) stretches_.back().lead_to(here);
    stretches_.push_back(here);
    // The last beam is a border too.
    beam = beam + 1 == times.beams ? times.beams : std::min(beam + step_, times.beams - 1);
  }
  if (!moves || worst == PoseOrigin::missing) stand();
  return worst;
}

void SweepMotion::Stretch::lead_to(const Stretch& next) {
  end = next.begin;
  change = (next.from - from) / static_cast<double>(end - begin);
}

namespace {

constexpr double most_between_borders_s = 1e-3;
constexpr double longest_cloud_s = 10;

}  // namespace

/// False if a pose is missing.
bool CloudMotion::find_borders(Stamp end, const Pose& vehicle_from_cloud, const PoseTrack& track) {
  const double length = seconds(end - begin_);
  if (!(length <= longest_cloud_s)) return false;
  const auto spans = static_cast<std::size_t>(std::max(1.0, std::ceil(length / most_between_borders_s)));
  border_span_s_ = length / static_cast<double>(spans);
  Pose now;
  if (track.at(instant_, now) == PoseOrigin::missing) return false;
  const Pose now_from_odom = (now * vehicle_from_cloud).inverse();
  bool moves = false;
  for (std::size_t i = 0; i <= spans; ++i) {
    Pose pose;
    const Stamp border =
        i == spans ? end : begin_ + span_from_seconds(static_cast<double>(i) * border_span_s_);
    if (track.at(border, pose) == PoseOrigin::missing) return false;
    borders_.emplace_back(Matrix::Identity());
    // A vehicle that stands must leave every return where it is to the last bit.
    if (pose.matrix() == now.matrix()) continue;
    moves = true;
    borders_.back() = (now_from_odom * pose * vehicle_from_cloud).matrix().topRows<3>();
  }
  if (!moves) borders_.clear();
  return true;
}

Pose CloudMotion::at(double after_s) const {
  Pose pose = Pose::Identity();
  if (stands()) return pose;
  const double last = static_cast<double>(borders_.size() - 1);
  const double border = border_span_s_ > 0 && after_s > 0 ? std::min(after_s / border_span_s_, last) : 0;
  const auto before = std::min(static_cast<std::size_t>(border), borders_.size() - 2);
  const double share = border - static_cast<double>(before);
  pose.affine() = borders_[before] + share * (borders_[before + 1] - borders_[before]);
  return pose;
}

bool CloudMotion::find(const Cloud& cloud, const Pose& vehicle_from_cloud, const PoseTrack& track,
                       std::optional<Stamp> instant) {
  columns_.clear();
  borders_.clear();
  if (track.empty() || !track.covers(cloud.stamp, cloud.end)) return false;
  begin_ = cloud.stamp;
  const Stamp end = std::max(cloud.stamp, cloud.end);
  instant_ = instant.value_or(std::max(begin_, std::min(end, track.newest())));
  if (!find_borders(end, vehicle_from_cloud, track)) {
    borders_.clear();
    return false;
  }
  if (borders_.empty()) return true;
  for (const CloudColumn& column : cloud.columns) columns_.push_back(at(seconds(column.stamp - begin_)));
  return true;
}

void move_points(const CloudMotion& motion, const Pose& frame_from_lidar, Cloud& cloud) {
  CloudPoint* const points = cloud.points();
  Pose transform = frame_from_lidar;
  const auto move = [&](CloudPoint& point) {
    const Eigen::Vector3d moved = transform * Eigen::Vector3f(point.x, point.y, point.z).cast<double>();
    point.x = static_cast<float>(moved.x());
    point.y = static_cast<float>(moved.y());
    point.z = static_cast<float>(moved.z());
  };
  const std::vector<Pose>& columns = motion.columns();
  if (motion.stands() || columns.empty()) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (!motion.stands()) transform = frame_from_lidar * motion.at(static_cast<double>(points[i].time));
      move(points[i]);
    }
    return;
  }
  for (std::size_t c = 0; c < columns.size(); ++c) {
    transform = frame_from_lidar * columns[c];
    for (std::size_t i = cloud.columns[c].first_point; i < cloud.points_end(c); ++i) move(points[i]);
  }
}

}  // namespace lidard
