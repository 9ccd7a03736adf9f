// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/cloud_merger.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lidard {
namespace {

/// Sizes of clouds differ from turn to turn: a buffer that grows gets room for the next ones.
void make_room(std::size_t bytes, PointBytes& buffer) {
  if (buffer.capacity() < bytes) buffer.reserve(bytes + bytes / 8);
}

/// A sweep as a cloud of one ring: a firing sequence for each beam and echo.
void to_cloud(const PlanarScan& scan, bool with_points, Cloud& cloud) {
  cloud.clear();
  cloud.frame_id = scan.frame_id;
  cloud.stamp = scan.stamp;
  cloud.end = times_of(scan).last();
  cloud.rings = 1;
  cloud.complete = true;
  if (!with_points) return;
  cloud.points_bytes.resize(scan.ranges.size() * sizeof(CloudPoint));
  std::uint32_t points = 0;
  for (std::size_t beam = 0; beam < scan.beams; ++beam) {
    const float angle = scan.angle(beam);
    const float time = scan.time_increment * static_cast<float>(beam);
    for (std::size_t echo = 0; echo < scan.echoes; ++echo) {
      const std::size_t i = scan.index(beam, echo);
      cloud.columns.push_back(
          {points, 0, 0, static_cast<std::uint8_t>(echo), angle, times_of(scan).at(beam)});
      if (scan.statuses[i] != BeamStatus::hit) continue;
      cloud.points()[points++] = {scan.ranges[i] * std::cos(angle),
                                  scan.ranges[i] * std::sin(angle),
                                  0,
                                  scan.intensities.empty() ? 0 : scan.intensities[i],
                                  0,
                                  time};
    }
  }
  cloud.points_bytes.resize(points * sizeof(CloudPoint));
}

using Transform = Eigen::Matrix<float, 3, 4>;

/// A return in the frame of the merged cloud.
MergedPoint moved(const CloudPoint& p, const Transform& t, float time, std::uint16_t sensor) {
  return {{t(0, 0) * p.x + t(0, 1) * p.y + t(0, 2) * p.z + t(0, 3),
           t(1, 0) * p.x + t(1, 1) * p.y + t(1, 2) * p.z + t(1, 3),
           t(2, 0) * p.x + t(2, 1) * p.y + t(2, 2) * p.z + t(2, 3), p.intensity, p.ring, p.time + time},
          sensor};
}

}  // namespace

CloudMerger::CloudMerger(std::size_t sources, bool organised)
    : organised_(organised), sources_(sources), placed_(sources), first_slots_(sources) {
  report_.sources.assign(sources, SourceUse::not_used);
}

void CloudMerger::reset() {
  for (Source& source : sources_) {
    source.stamp.reset();
    source.fresh = false;
  }
}

bool CloudMerger::accept(std::size_t index, Stamp stamp, const Pose& vehicle_from_cloud) {
  Source& source = sources_[index];
  if (source.stamp && stamp + restart_limit < *source.stamp) reset();
  if (source.stamp && stamp <= *source.stamp) {
    ++out_of_order_;
    return false;
  }
  if (source.fresh) ++superseded_;
  source.stamp = stamp;
  source.fresh = true;
  source.vehicle_from_cloud = vehicle_from_cloud;
  return true;
}

bool CloudMerger::add(std::size_t index, const Cloud& cloud, const Pose& vehicle_from_cloud,
                      bool with_points) {
  if (!accept(index, cloud.stamp, vehicle_from_cloud)) return false;
  Cloud& kept = sources_[index].cloud;
  sources_[index].is_sweep = false;
  if (!with_points) return kept.clear(), true;
  make_room(cloud.points_bytes.size(), kept.points_bytes);
  kept = cloud;
  return true;
}

bool CloudMerger::add(std::size_t index, const PlanarScan& scan, const Pose& vehicle_from_scan,
                      bool with_points) {
  if (!has_usable_times(scan) || !accept(index, scan.stamp, vehicle_from_scan)) return false;
  sources_[index].is_sweep = true;
  to_cloud(scan, with_points, sources_[index].cloud);
  return true;
}

SourceUse CloudMerger::bring(Source& source, const MergeMoment& moment) const {
  source.fresh = false;
  if (moment.track == nullptr ||
      !source.motion.find(source.cloud, source.vehicle_from_cloud, *moment.track, moment.at))
    return SourceUse::static_poses;
  const bool known = std::max(source.cloud.end, moment.at) <= moment.track->newest();
  return known ? SourceUse::deskewed : SourceUse::extrapolated;
}

bool CloudMerger::can_be_organised() const {
  return organised_ && std::all_of(placed_.begin(), placed_.end(), [](const PlacedCloud& placed) {
           return placed.cloud == nullptr || (placed.cloud->rings > 0 && !placed.cloud->columns.empty());
         });
}

/// Gives each source its slots in the merged cloud. Slots of an organised one are NaN until a return is
/// written there.
void CloudMerger::set_slots(MergedCloud& merged) {
  std::size_t rows = 0, points = 0;
  width_ = 0;
  const bool organised = can_be_organised();
  for (const PlacedCloud& placed : placed_) {
    if (placed.cloud != nullptr && organised) width_ = std::max(width_, placed.cloud->columns.size());
  }
  for (std::size_t s = 0; s < placed_.size(); ++s) {
    first_slots_[s] = organised ? rows * width_ : points;
    if (placed_[s].cloud == nullptr) continue;
    rows += placed_[s].cloud->rings;
    points += placed_[s].cloud->size();
  }
  merged.height = organised ? static_cast<std::uint32_t>(rows) : 0;
  const std::size_t bytes = (organised ? rows * width_ : points) * sizeof(MergedPoint);
  make_room(bytes, merged.points_bytes);
  merged.points_bytes.resize(bytes);
  if (!organised) return;
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  for (std::size_t s = 0; s < placed_.size(); ++s) {
    if (placed_[s].cloud == nullptr) continue;
    const Cloud& cloud = *placed_[s].cloud;
    for (std::uint16_t ring = 0; ring < cloud.rings; ++ring) {
      MergedPoint* const row = merged.points() + first_slots_[s] + ring * width_;
      for (std::size_t c = 0; c < width_; ++c) {
        const Stamp begin = c < cloud.columns.size() ? cloud.columns[c].stamp : cloud.end;
        const auto time = static_cast<float>(seconds(begin - merged.stamp));
        row[c] = {{nan, nan, nan, nan, ring, time}, static_cast<std::uint16_t>(s)};
      }
    }
  }
}

void CloudMerger::write(std::size_t index, const Pose& output_from_base, MergedCloud& merged) const {
  const PlacedCloud& placed = placed_[index];
  const Cloud& cloud = *placed.cloud;
  const auto sensor = static_cast<std::uint16_t>(index);
  const auto time = static_cast<float>(seconds(cloud.stamp - merged.stamp));
  const Pose output_from_lidar = output_from_base * placed.vehicle_from_cloud;
  const auto transform_of = [&](const Pose& move) -> Transform {
    return (output_from_lidar * move).matrix().topRows<3>().cast<float>();
  };
  MergedPoint* const out = merged.points() + first_slots_[index];
  Transform transform = transform_of(Pose::Identity());
  if (cloud.columns.empty()) {
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const CloudPoint& point = cloud.points()[i];
      if (placed.motion != nullptr)
        transform = transform_of(placed.motion->at(static_cast<double>(point.time)));
      out[i] = moved(point, transform, time, sensor);
    }
    return;
  }
  for (std::size_t c = 0; c < cloud.columns.size(); ++c) {
    if (placed.motion != nullptr) transform = transform_of(placed.motion->columns()[c]);
    const std::size_t end = cloud.points_end(c);
    for (std::size_t i = cloud.columns[c].first_point; i < end; ++i) {
      const CloudPoint& point = cloud.points()[i];
      const std::size_t slot = width_ == 0 ? i : point.ring * width_ + c;
      if (width_ == 0 || point.ring < cloud.rings) out[slot] = moved(point, transform, time, sensor);
    }
  }
}

const MergeReport& CloudMerger::merge(const MergeMoment& moment, const std::vector<char>& use,
                                      MergedCloud& merged) {
  report_.deskewed = false;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    Source& source = sources_[s];
    report_.sources[s] = SourceUse::not_used;
    placed_[s] = {};
    if (use[s] == 0 || !source.stamp) continue;
    report_.sources[s] = bring(source, moment);
    const bool moves = report_.sources[s] != SourceUse::static_poses;
    report_.deskewed = report_.deskewed || moves;
    placed_[s] = {&source.cloud, source.vehicle_from_cloud,
                  moves && !source.motion.stands() ? &source.motion : nullptr, source.is_sweep};
  }
  merged.stamp = moment.at;
  set_slots(merged);
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (placed_[s].cloud != nullptr) write(s, moment.output_from_base, merged);
  }
  return report_;
}

}  // namespace lidard
