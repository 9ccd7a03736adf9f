// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merger.h"

#include <algorithm>
#include <cmath>

namespace lidard {

Merger::Merger(const ScanGrid& grid, HeightBand band, std::size_t sources, Span lost_after)
    : flattener_(grid, band), lost_after_(lost_after), sources_(sources) {}

void Merger::reset() {
  for (Source& source : sources_) {
    source.points.clear();
    source.stamp.reset();
    source.fresh = false;
  }
  first_.reset();
  last_output_.reset();
}

bool Merger::alive(std::size_t source) const {
  if (!first_) return false;
  // A source never heard of gets the same patience, counted from the first sweep of any.
  const Stamp last = sources_[source].stamp.value_or(*first_);
  return newest_ - last <= lost_after_;
}

bool Merger::is_due() const {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (alive(s) && !sources_[s].fresh) return false;
  }
  return true;
}

bool Merger::add(std::size_t index, const PlanarScan& scan, const Pose& output_from_sensor) {
  Source& source = sources_[index];
  // Far back it is no late sweep but a clock that was set, or an input that starts again.
  constexpr Span restart_limit = std::chrono::seconds(1);
  if (first_ && scan.stamp + restart_limit < newest_) reset();
  if (source.stamp && scan.stamp <= *source.stamp) {
    ++out_of_order_;
    return false;
  }
  if (source.fresh) ++superseded_;
  if (!first_) first_ = newest_ = scan.stamp;
  newest_ = std::max(newest_, scan.stamp);
  source.stamp = scan.stamp;
  source.fresh = true;
  source.has_intensities = !scan.intensities.empty();
  source.scan_time = scan.scan_time;
  source.points.clear();
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    if (scan.statuses[i] != BeamStatus::hit) continue;
    const std::size_t beam = i % scan.beams;
    const double angle = static_cast<double>(scan.angle_min) +
                         static_cast<double>(beam) * static_cast<double>(scan.angle_increment);
    const auto range = static_cast<double>(scan.ranges[i]);
    const Eigen::Vector3d in_sensor(range * std::cos(angle), range * std::sin(angle), 0);
    source.points.push_back(
        {output_from_sensor * in_sensor, source.has_intensities ? scan.intensities[i] : 0.0F});
  }
  return is_due();
}

void Merger::merge(PlanarScan& scan, Cloud* cloud) {
  bool intensities = true;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (alive(s) && sources_[s].stamp && !sources_[s].has_intensities) intensities = false;
  }
  flattener_.begin(scan, intensities);
  if (cloud != nullptr) {
    cloud->clear();
    cloud->rings = static_cast<std::uint16_t>(sources_.size());
    cloud->complete = true;
  }
  Stamp stamp{};
  float scan_time = 0;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    Source& source = sources_[s];
    source.fresh = false;
    if (!source.stamp || !alive(s)) continue;
    stamp = std::max(stamp, *source.stamp);
    scan_time = std::max(scan_time, source.scan_time);
    for (const Point& point : source.points) flattener_.add(point.position, point.intensity);
    if (cloud == nullptr) continue;
    const std::size_t begin = cloud->points_bytes.size();
    cloud->points_bytes.resize(begin + source.points.size() * sizeof(CloudPoint));
    CloudPoint* out = cloud->points() + begin / sizeof(CloudPoint);
    for (const Point& point : source.points) {
      const Eigen::Vector3f p = point.position.cast<float>();
      *out++ = {p.x(), p.y(), p.z(), point.intensity, static_cast<std::uint16_t>(s), 0};
    }
  }
  if (last_output_ && stamp <= *last_output_) stamp = *last_output_ + Span(1);
  last_output_ = stamp;
  scan.stamp = stamp;
  if (scan.scan_time == 0) scan.scan_time = scan_time;
  if (cloud != nullptr) cloud->stamp = cloud->end = stamp;
}

}  // namespace lidard
