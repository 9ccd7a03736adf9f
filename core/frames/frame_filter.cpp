// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/frame_filter.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/frames/scan_points.h"

namespace lidard {
namespace {

/// The number of the cube of `size` m that holds a point, and the squared distance from its centre. 21 bits
/// for each axis count a million cubes in both directions: 10 km of the smallest ones.
std::pair<std::uint64_t, float> voxel_of(const CloudPoint& point, double size) {
  std::uint64_t number = 0;
  float off_centre = 0;
  for (const float along : {point.x, point.y, point.z}) {
    const double cubes = std::clamp(static_cast<double>(along) / size, -1e6, 1e6);
    const double cube = std::floor(cubes);
    const auto off = static_cast<float>(cubes - cube - 0.5);
    number = number << 21U | (static_cast<std::uint64_t>(static_cast<std::int64_t>(cube)) & 0x1FFFFFU);
    off_centre += off * off;
  }
  return {number, off_centre};
}

/// Moves the kept values to the front.
template <class Value>
void keep(std::vector<Value>& values, const std::vector<FilterVerdict>& verdicts) {
  if (values.empty()) return;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    if (verdicts[i] == FilterVerdict::kept) values[kept++] = values[i];
  }
  values.resize(kept);
}

/// Moves the echoes of a beam that stay to the front; `verdict` stands at its first return and is moved
/// behind its last one.
void keep_echoes(std::size_t beam, const FilterVerdict*& verdict, PlanarScan& scan) {
  std::size_t kept = 0;
  bool removed = false;
  for (std::size_t echo = 0; echo < scan.echoes; ++echo) {
    const std::size_t from = scan.index(beam, echo);
    if (scan.statuses[from] == BeamStatus::hit && *verdict++ != FilterVerdict::kept) {
      removed = true;
      continue;
    }
    const std::size_t to = scan.index(beam, kept++);
    scan.statuses[to] = scan.statuses[from];
    scan.ranges[to] = scan.ranges[from];
    if (!scan.intensities.empty()) scan.intensities[to] = scan.intensities[from];
  }
  // That there was no second echo does not show that there is nothing.
  if (removed && kept > 0 && scan.statuses[scan.index(beam)] == BeamStatus::none) kept = 0;
  for (; kept < scan.echoes; ++kept) {
    const std::size_t i = scan.index(beam, kept);
    scan.set_without_hit(i, BeamStatus::invalid);
    if (!scan.intensities.empty()) scan.intensities[i] = 0;
  }
}

}  // namespace

FilterVerdict FrameFilter::judge(const CloudPoint& point, bool with_intensities) const {
  const FrameFilterSettings& s = settings_;
  if (with_intensities && s.intensity_min && !(static_cast<double>(point.intensity) >= *s.intensity_min))
    return FilterVerdict::intensity;
  const Eigen::Vector3d position = Eigen::Vector3f(point.x, point.y, point.z).cast<double>();
  const bool stays = (!s.box || s.box->contains(position)) && !(s.cut_out && s.cut_out->contains(position));
  return stays ? FilterVerdict::kept : FilterVerdict::box;
}

void FrameFilter::judge(const CloudPoint* points, std::size_t returns, bool with_intensities) {
  verdicts_.resize(returns);
  for (std::size_t i = 0; i < returns; ++i) verdicts_[i] = judge(points[i], with_intensities);
  if (settings_.voxel_size > 0) judge_voxels(points);
  if (settings_.outlier_radius > 0) judge_outliers(points);
  if (settings_.intensity_min && returns > 0) counters_.has_no_intensities = !with_intensities;
  count(returns);
}

void FrameFilter::judge_voxels(const CloudPoint* points) {
  candidates_.clear();
  for (std::size_t i = 0; i < verdicts_.size(); ++i) {
    if (verdicts_[i] != FilterVerdict::kept) continue;
    const auto [voxel, off_centre] = voxel_of(points[i], settings_.voxel_size);
    candidates_.push_back({voxel, off_centre, static_cast<std::uint32_t>(i)});
  }
  std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.voxel, a.off_centre, a.index) < std::tie(b.voxel, b.off_centre, b.index);
  });
  for (std::size_t i = 1; i < candidates_.size(); ++i) {
    if (candidates_[i].voxel == candidates_[i - 1].voxel)
      verdicts_[candidates_[i].index] = FilterVerdict::voxel;
  }
}

void FrameFilter::judge_outliers(const CloudPoint* points) {
  left_.clear();
  for (std::size_t i = 0; i < verdicts_.size(); ++i) {
    if (verdicts_[i] == FilterVerdict::kept) left_.push_back(points[i]);
  }
  inliers_.resize(left_.size());
  settings_.find_inliers(left_.data(), left_.size(), settings_.outlier_radius, settings_.outlier_neighbours,
                         inliers_.data());
  auto inlier = inliers_.begin();
  for (FilterVerdict& verdict : verdicts_) {
    if (verdict == FilterVerdict::kept && *inlier++ == 0) verdict = FilterVerdict::outlier;
  }
}

void FrameFilter::count(std::size_t returns) {
  std::uint64_t kept = 0;
  std::uint64_t* const of[] = {&kept, &counters_.by_intensity, &counters_.by_box, &counters_.by_voxel,
                               &counters_.outliers};
  for (const FilterVerdict verdict : verdicts_) ++*of[static_cast<std::size_t>(verdict)];
  counters_.returns += returns;
  // An empty frame shows nothing about the filter.
  if (kept > 0)
    counters_.emptied_in_a_row = 0;
  else if (returns > 0)
    ++counters_.emptied_in_a_row;
}

void FrameFilter::apply(Cloud& cloud) {
  judge(cloud.points(), cloud.size(), true);
  std::size_t kept = 0;
  auto column = cloud.columns.begin();
  for (std::size_t i = 0; i <= verdicts_.size(); ++i) {
    for (; column != cloud.columns.end() && column->first_point == i; ++column)
      column->first_point = static_cast<std::uint32_t>(kept);
    if (i == verdicts_.size() || verdicts_[i] != FilterVerdict::kept) continue;
    cloud.points()[kept++] = cloud.points()[i];
  }
  cloud.points_bytes.resize(kept * sizeof(CloudPoint));
  keep(cloud.origins, verdicts_);
}

void FrameFilter::apply(PlanarScan& scan) {
  points_.clear();
  append_points(scan, points_);
  judge(points_.data(), points_.size(), !scan.intensities.empty());
  const FilterVerdict* verdict = verdicts_.data();
  for (std::size_t beam = 0; beam < scan.beams; ++beam) keep_echoes(beam, verdict, scan);
}

}  // namespace lidard
