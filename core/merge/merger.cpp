// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/merge/merger.h"

#include <algorithm>
#include <cmath>

namespace lidard {

Merger::Merger(const ScanGrid& grid, HeightBand band, std::size_t sources, const MergeSettings& settings)
    : settings_(settings),
      band_(band),
      flattener_(grid, band),
      newest_sweeps_(sources, nullptr),
      sources_(sources) {
  report_.sources.assign(sources, SourceUse::not_used);
  if (!settings.visibility) return;
  visibility_.emplace(grid, settings.how, sources);
  for (std::size_t s = 0; s < sources; ++s)
    if (!settings_of(s).proves_free) visibility_->set_kind(s, Visibility::blind);
}

void Merger::set_footprint(const Footprint& footprint) {
  footprint_ = footprint;
  flattener_.set_footprint(footprint.padded(Footprint::margin_m));
  if (visibility_) visibility_->set_footprint(footprint);
  for (Source& source : sources_) source.rays_outdated = true;
}

void Merger::reset() {
  for (Source& source : sources_) {
    source.points.clear();
    source.stamp.reset();
    source.fresh = false;
  }
}

bool Merger::add(std::size_t index, const PlanarScan& scan, const Pose& output_from_sensor) {
  Source& source = sources_[index];
  if (!has_usable_times(scan)) {
    ++bad_times_;
    return false;
  }
  // A stamp far back is not a late sweep: the clock was set, or the input starts again.
  if (source.stamp && scan.stamp + restart_limit < *source.stamp) reset();
  if (source.stamp && scan.stamp <= *source.stamp) {
    ++out_of_order_;
    return false;
  }
  if (source.fresh) ++superseded_;
  source.stamp = scan.stamp;
  source.times = times_of(scan);
  source.fresh = true;
  source.has_intensities = !scan.intensities.empty();
  source.scan_time = scan.scan_time;
  if (source.rays_outdated || !source.rays.fits(scan, output_from_sensor)) {
    source.rays_outdated = false;
    source.rays.build(scan, output_from_sensor, footprint_, band_);
    source.sweep.passes_vehicle.clear();
    if (visibility_) visibility_->set_source(index, source.rays);
  }
  if (settings_.points) transform_points(scan, settings_of(index), source);
  if (visibility_) measure(scan, source.rays, settings_of(index), source.sweep);
  return true;
}

void Merger::transform_points(const PlanarScan& scan, const SourceSettings& settings, Source& source) {
  source.points.clear();
  const Eigen::Vector3d origin = source.rays.pose.translation();
  for (std::size_t echo = 0; echo < scan.echoes; ++echo) {
    for (std::size_t beam = 0; beam < scan.beams; ++beam) {
      const std::size_t i = scan.index(beam, echo);
      if (scan.statuses[i] != BeamStatus::hit || !settings.wants(scan, i)) continue;
      source.points.push_back({origin + static_cast<double>(scan.ranges[i]) * source.rays.direction[beam],
                               source.has_intensities ? scan.intensities[i] : 0,
                               static_cast<std::uint32_t>(beam)});
    }
  }
}

std::optional<SweepTimes> Merger::times(std::size_t source) const {
  if (!sources_[source].stamp) return std::nullopt;
  return sources_[source].times;
}

bool Merger::with_intensities(const std::vector<char>& use) const {
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (use[s] != 0 && sources_[s].stamp && !sources_[s].has_intensities) return false;
  }
  return true;
}

template <class Use>
void Merger::each_point(const Source& source, Use use) {
  if (source.motion.stands()) {
    for (const Point& point : source.points) use(point.position, point);
  } else {
    for (const Point& point : source.points) use(source.motion.moved(point.beam, point.position), point);
  }
}

void Merger::flatten(PlanarScan& scan, bool intensities) {
  flattener_.begin(scan, intensities);
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (!used(s)) continue;
    const bool moves = !sources_[s].motion.stands();
    each_point(sources_[s], [&](const Eigen::Vector3d& here, const Point& measured) {
      // The vehicle's own returns move with the vehicle, so the measured position is checked too.
      if (!moves || !flattener_.is_own(measured.position)) flattener_.add(here, measured.intensity);
    });
  }
  flattener_.end();
}

void Merger::fill(Cloud& cloud) const {
  cloud.clear();
  cloud.rings = static_cast<std::uint16_t>(sources_.size());
  cloud.complete = true;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (!used(s)) continue;
    const std::size_t begin = cloud.points_bytes.size();
    cloud.points_bytes.resize(begin + sources_[s].points.size() * sizeof(CloudPoint));
    CloudPoint* out = cloud.points() + begin / sizeof(CloudPoint);
    each_point(sources_[s], [&](const Eigen::Vector3d& here, const Point& measured) {
      const Eigen::Vector3f p = here.cast<float>();
      *out++ = {p.x(), p.y(), p.z(), measured.intensity, static_cast<std::uint16_t>(s), 0};
    });
  }
}

/// Transforms a source's sweep to the output frame at the given moment.
SourceUse Merger::transform_source(std::size_t index, const MergeMoment& moment) {
  Source& source = sources_[index];
  source.fresh = false;
  const PoseOrigin origin = source.motion.follow(moment, source.times);
  if (visibility_) {
    transform(source.rays, source.motion, settings_of(index).noise, source.sweep);
    newest_sweeps_[index] = &source.sweep;
  }
  if (origin == PoseOrigin::missing) return SourceUse::static_poses;
  report_.deskewed = true;
  return origin == PoseOrigin::known ? SourceUse::deskewed : SourceUse::extrapolated;
}

const MergeReport& Merger::merge(const MergeMoment& moment, const std::vector<char>& use,
                                 const std::vector<MergedScan>& outputs, Cloud* cloud) {
  const bool intensities = with_intensities(use);
  float scan_time = 0;
  report_.deskewed = false;
  const Source* oldest = nullptr;  // of those that moved
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    newest_sweeps_[s] = nullptr;
    report_.sources[s] = SourceUse::not_used;
    if (use[s] == 0 || !sources_[s].stamp) continue;
    report_.sources[s] = transform_source(s, moment);
    scan_time = std::max(scan_time, sources_[s].scan_time);
    if (sources_[s].motion.stands() || (oldest != nullptr && oldest->stamp < sources_[s].stamp)) continue;
    oldest = &sources_[s];
  }
  if (visibility_) {
    visibility_->set_former(oldest == nullptr ? std::nullopt
                                              : std::optional(oldest->motion.begin().inverse()));
    visibility_->compute(newest_sweeps_);
  }
  for (const MergedScan& output : outputs) {
    if (output.profile == Profile::flatten)
      flatten(*output.scan, intensities);
    else
      visibility_->encode(output.profile, *output.scan, intensities);
    output.scan->stamp = moment.at;
    // All beams are deskewed to one instant; consumers must not deskew them again.
    if (report_.deskewed) output.scan->time_increment = 0;
    if (output.scan->scan_time == 0) output.scan->scan_time = scan_time;
  }
  if (cloud == nullptr) return report_;
  fill(*cloud);
  cloud->stamp = cloud->end = moment.at;
  return report_;
}

}  // namespace lidard
