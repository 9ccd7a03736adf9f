// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/still_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.h"

namespace lidard {
namespace {

constexpr std::size_t bins = 1800;  // of a turn of a multi-plane lidar
// No lidar has more; a cloud of another driver may claim 65535.
constexpr std::size_t most_rings = 256;
// A beam counts if so many frames show it: leaves and people give less. A turn of a multi-plane lidar at full
// speed meets every second bin.
constexpr double least_share = 0.6, least_share_of_bin = 0.25;
// No range is better known than this, m: a step of 2 mm, whose error the mean does not lose where there is
// little noise.
constexpr double finest = 0.0006;
constexpr double mad_to_sigma = 1.4826;

template <class Value>
double median_of(std::vector<Value>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return static_cast<double>(*middle);
}

}  // namespace

void estimate_noise(StillView& view, std::vector<double>& bends) {
  bends.clear();
  const std::vector<StillBeam>& beams = view.beams;
  for (std::size_t i = 1; i + 1 < beams.size(); ++i) {
    const double bend = std::abs(beams[i - 1].range - 2 * beams[i].range + beams[i + 1].range);
    if (std::isfinite(bend)) bends.push_back(bend);
  }
  constexpr double bend_to_sigma = mad_to_sigma / 2.449;  // square root of 6
  const double sigma = bends.empty() ? 0.01 : std::clamp(bend_to_sigma * median_of(bends), 0.001, 0.03);
  for (StillBeam& beam : view.beams) beam.sigma = sigma;
}

void StillScans::Samples::add(float range, const Eigen::Vector3f& along) {
  ++seen;
  if (ranges.size() < most) ranges.push_back(range), ray += along;
}

double StillScans::Samples::median(double enough, double& sigma) const {
  if (static_cast<double>(nothing) >= enough) return std::numeric_limits<double>::infinity();
  if (ranges.empty() || static_cast<double>(seen) < enough) return std::numeric_limits<double>::quiet_NaN();
  std::vector<float> sorted = ranges;
  const double middle = median_of(sorted);
  // Ranges have steps, so that the mean of those near the median is finer than the median.
  std::vector<float> off;
  for (const float range : ranges) off.push_back(std::abs(range - static_cast<float>(middle)));
  const double spread = std::max(mad_to_sigma * median_of(off), 0.001);
  double sum = 0, count = 0;
  for (const float range : ranges) {
    if (std::abs(static_cast<double>(range) - middle) > 3 * spread) continue;
    sum += static_cast<double>(range), ++count;
  }
  sigma = std::max(finest, spread / std::sqrt(count));
  return sum / count;
}

bool StillScans::add(const PlanarScan& scan) {
  const auto step = static_cast<double>(scan.angle_increment);
  if (scan.beams == 0) return false;
  if (frames_ == 0) {
    rings_.assign(1, std::vector<Samples>(scan.beams));
    angle_min_ = static_cast<double>(scan.angle_min), step_ = step;
  }
  if (rings_.size() != 1 || rings_[0].size() != scan.beams || std::abs(step - step_) > 1e-7 ||
      std::abs(static_cast<double>(scan.angle_min) - angle_min_) > 0.1 * std::abs(step_))
    return false;
  ++frames_;
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const double angle = scan.wave.bent(angle_min_ + step_ * static_cast<double>(i));
    if (scan.statuses[i] == BeamStatus::hit)
      rings_[0][i].add(scan.ranges[i],
                       {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)), 0});
    else if (scan.statuses[i] == BeamStatus::none)
      ++rings_[0][i].nothing;
  }
  return true;
}

void StillScans::add(const Cloud& cloud) {
  ++frames_, ++cloud_frames_;
  step_ = two_pi / static_cast<double>(bins);
  const CloudPoint* const points = cloud.points();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3f p(points[i].x, points[i].y, points[i].z);
    const float range = p.norm();
    const std::size_t ring = points[i].ring;
    if (!(range > 0.1F) || ring >= most_rings) continue;
    if (rings_.size() <= ring) rings_.resize(ring + 1, std::vector<Samples>(bins));
    const double azimuth = std::atan2(static_cast<double>(p.y()), static_cast<double>(p.x())) + pi_d;
    const auto bin = static_cast<std::size_t>(azimuth / step_);
    rings_[ring][std::min(bin, bins - 1)].add(range, p / range);
  }
}

std::size_t StillScans::stride(const std::vector<Samples>& ring) const {
  if (!is_cloud()) return 1;
  std::vector<std::size_t> gaps;
  for (std::size_t i = 0, last = bins; i < ring.size(); ++i) {
    if (ring[i].seen == 0) continue;
    if (last < i) gaps.push_back(i - last);
    last = i;
  }
  return gaps.empty() ? 1 : static_cast<std::size_t>(median_of(gaps));
}

double StillScans::enough() const {
  return (is_cloud() ? least_share_of_bin : least_share) * static_cast<double>(frames_);
}

std::vector<Eigen::Vector3d> StillScans::points() const {
  std::vector<Eigen::Vector3d> all;
  double sigma = 0;
  for (const auto& ring : rings_) {
    for (const Samples& beam : ring) {
      const double range = beam.median(enough(), sigma);
      if (range < 1e9) all.push_back(range * beam.ray.cast<double>().normalized());
    }
  }
  return all;
}

std::vector<StillView> StillScans::views(const Eigen::Matrix3d& tilt) const {
  std::vector<StillView> views;
  for (std::size_t r = 0; r < rings_.size(); ++r) {
    StillView view;
    const std::size_t usual = stride(rings_[r]);
    view.ring = r, view.step = std::abs(step_) * static_cast<double>(usual);
    std::size_t empty = 0;
    for (std::size_t i = 0; i < rings_[r].size(); ++i) {
      const Samples& samples = rings_[r][i];
      // Bins between two beams are no gap, nor is a single one that rounding leaves out.
      empty = is_cloud() && samples.seen == 0 ? empty + 1 : 0;
      if (empty > 0 && empty != usual + 1) continue;
      StillBeam beam;
      const double range = samples.median(enough(), beam.sigma);
      const double angle = angle_min_ + step_ * static_cast<double>(i);
      const Eigen::Vector3d ray = samples.ranges.empty()
                                      ? Eigen::Vector3d(std::cos(angle), std::sin(angle), 0)
                                      : Eigen::Vector3d(samples.ray.cast<double>().normalized());
      const Eigen::Vector3d along = tilt * ray;
      const double flat = along.head<2>().norm();
      beam.range = range * flat;
      beam.sigma *= flat;
      beam.point = beam.is_hit() ? Eigen::Vector2d(range * along.head<2>()) : along.head<2>().normalized();
      beam.height = beam.is_hit() ? range * along.z() : 0;
      view.beams.push_back(beam);
    }
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace lidard
