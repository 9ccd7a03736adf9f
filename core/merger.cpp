// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merger.h"

#include <algorithm>
#include <cmath>

namespace lidard {

Merger::Merger(const ScanGrid& grid, HeightBand band, std::size_t sources, Span lost_after,
               const MergeSettings& settings)
    : settings_(settings),
      band_(band),
      flattener_(grid, band),
      newest_sweeps_(sources, nullptr),
      lost_after_(lost_after),
      sources_(sources) {
  if (settings.sight) sight_.emplace(grid, settings.how, sources);
}

void Merger::set_footprint(const Footprint& footprint) {
  footprint_ = footprint;
  flattener_.set_footprint(footprint.padded(Footprint::margin_m));
  if (sight_) sight_->set_footprint(footprint);
  for (Source& source : sources_) source.rays = {};
}

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
  if (settings_.points) take_points(scan, output_from_sensor, source);
  if (sight_) take_sweep(index, scan, output_from_sensor);
  return is_due();
}

void Merger::take_points(const PlanarScan& scan, const Pose& output_from_sensor, Source& source) const {
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
}

void Merger::take_sweep(std::size_t index, const PlanarScan& scan, const Pose& output_from_sensor) {
  Source& source = sources_[index];
  if (!source.rays.fits(scan, output_from_sensor)) {
    source.rays.build(scan, output_from_sensor, footprint_, band_);
    sight_->set_source(index, source.rays);
  }
  condition(scan, source.rays, settings_.source, source.sweep);
}

bool Merger::intensities_everywhere() const {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (used(s) && !sources_[s].has_intensities) return false;
  }
  return true;
}

void Merger::flatten(PlanarScan& scan, bool intensities) {
  flattener_.begin(scan, intensities);
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (!used(s)) continue;
    for (const Point& point : sources_[s].points) flattener_.add(point.position, point.intensity);
  }
}

void Merger::fill(Cloud& cloud) const {
  cloud.clear();
  cloud.rings = static_cast<std::uint16_t>(sources_.size());
  cloud.complete = true;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (!used(s)) continue;
    const auto& points = sources_[s].points;
    const std::size_t begin = cloud.points_bytes.size();
    cloud.points_bytes.resize(begin + points.size() * sizeof(CloudPoint));
    CloudPoint* out = cloud.points() + begin / sizeof(CloudPoint);
    for (const Point& point : points) {
      const Eigen::Vector3f p = point.position.cast<float>();
      *out++ = {p.x(), p.y(), p.z(), point.intensity, static_cast<std::uint16_t>(s), 0};
    }
  }
}

void Merger::merge(const std::vector<MergedScan>& outputs, Cloud* cloud) {
  const bool intensities = intensities_everywhere();
  Stamp stamp{};
  float scan_time = 0;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    sources_[s].fresh = false;
    newest_sweeps_[s] = sight_ && used(s) ? &sources_[s].sweep : nullptr;
    if (!used(s)) continue;
    stamp = std::max(stamp, *sources_[s].stamp);
    scan_time = std::max(scan_time, sources_[s].scan_time);
  }
  if (last_output_ && stamp <= *last_output_) stamp = *last_output_ + Span(1);
  last_output_ = stamp;
  if (sight_) sight_->compute(newest_sweeps_);
  for (const MergedScan& output : outputs) {
    if (output.profile == Profile::flatten)
      flatten(*output.scan, intensities);
    else
      sight_->encode(output.profile, *output.scan, intensities);
    output.scan->stamp = stamp;
    if (output.scan->scan_time == 0) output.scan->scan_time = scan_time;
  }
  if (cloud == nullptr) return;
  fill(*cloud);
  cloud->stamp = cloud->end = stamp;
}

}  // namespace lidard
