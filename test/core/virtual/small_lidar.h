// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <functional>
#include <set>
#include <utility>
#include <vector>

#include "core/base/angle.h"
#include "core/frames/cloud.h"
#include "core/virtual/ring_grid.h"
#include "test/sim/world/rng.h"

namespace lidard::test::rings {

inline double turn_between(double a, double b) { return std::remainder(a - b, 2 * pi_d); }

/// rad, counted clockwise.
inline double azimuth_of(const BeamEnd& end) {
  return std::atan2(-static_cast<double>(end.y), static_cast<double>(end.x));
}
inline double norm(const BeamEnd& end) {
  return std::sqrt(static_cast<double>(end.x) * static_cast<double>(end.x) +
                   static_cast<double>(end.y) * static_cast<double>(end.y) +
                   static_cast<double>(end.z) * static_cast<double>(end.z));
}
inline double elevation_of(const BeamEnd& end) { return std::asin(static_cast<double>(end.z) / norm(end)); }

/// A lidar of few beams of which everything can be said: which came back, from how far, and which were lost.
struct SmallLidar {
  explicit SmallLidar(std::uint64_t seed) : rng(seed), first_azimuth(2 * pi_d * rng.uniform()) {
    offsets.assign(elevations.size(), 0);
  }
  double step() const { return 2 * pi_d / static_cast<double>(columns); }
  /// rad of a column, not wrapped.
  double azimuth(std::size_t column) const { return first_azimuth + static_cast<double>(column) * step(); }
  /// s after the cloud's stamp.
  double time(std::size_t column) const {
    return 0.1 * static_cast<double>(column) / static_cast<double>(columns);
  }
  /// Lasers point ahead by up to `most` columns and parts of one.
  void scatter_offsets(double most) {
    for (double& offset : offsets) offset = (2 * rng.uniform() - 1) * most * step();
  }
  void miss_some() {
    for (std::size_t c = 0; c < columns; ++c) {
      if (rng.uniform() < 0.2) missing.insert({c, static_cast<std::size_t>(rng.uniform() * 4)});
    }
  }
  Cloud cloud() {
    Cloud cloud;
    cloud.stamp = Stamp{1'700'000'000'000'000'000};
    cloud.rings = static_cast<std::uint16_t>(elevations.size());
    cloud.complete = true;
    std::vector<CloudPoint> points;
    for (std::size_t c = 0; c < (fired > 0 ? fired : columns); ++c) {
      if (lost.count(c) != 0) continue;
      const double shown = azimuth(c) + (jitter > 0 ? jitter * (2 * rng.uniform() - 1) * step() : 0);
      const Span after = span_from_seconds(time(c));
      cloud.columns.push_back({static_cast<std::uint32_t>(points.size()), 0, 0, 0,
                               static_cast<float>(shown - 2 * pi_d * std::floor(shown / (2 * pi_d))),
                               cloud.stamp + after});
      for (std::size_t r = 0; r < elevations.size(); ++r) {
        const double far = missing.count({c, r}) != 0 ? 0 : range(r, c);
        if (!(far > 0)) continue;
        const double a = -(shown + offsets[r]), e = elevations[r];
        points.push_back({static_cast<float>(far * std::cos(e) * std::cos(a)),
                          static_cast<float>(far * std::cos(e) * std::sin(a)),
                          static_cast<float>(far * std::sin(e)), static_cast<float>(1000 * r),
                          static_cast<std::uint16_t>(r), static_cast<float>(seconds(after))});
      }
    }
    cloud.end = cloud.columns.back().stamp;
    cloud.points_bytes.resize(points.size() * sizeof(CloudPoint));
    std::copy(points.begin(), points.end(), cloud.points());
    return cloud;
  }

  sim::Rng rng;
  std::vector<double> elevations = {-0.3, -0.2, -0.1, 0, 0.08};  ///< rad
  std::vector<double> offsets;                                   ///< rad, clockwise
  std::size_t columns = 360;
  std::size_t fired = 0;  ///< columns of the cloud; 0: a turn
  double first_azimuth;
  double jitter = 0;                                      ///< columns
  std::set<std::size_t> lost;                             ///< columns
  std::set<std::pair<std::size_t, std::size_t>> missing;  ///< column, ring
  /// m by ring and column; 0: no return.
  std::function<double(std::size_t, std::size_t)> range = [](std::size_t ring, std::size_t column) {
    return 6 + 0.3 * static_cast<double>(ring) + 3 * std::sin(0.05 * static_cast<double>(column));
  };
};

/// Firings with two returns: of each column those of `first`, then those of `second`.
inline Cloud both_echoes(const Cloud& first, const Cloud& second) {
  Cloud both = first;
  both.columns.clear();
  both.points_bytes.clear();
  for (std::size_t c = 0; c < first.columns.size(); ++c) {
    for (const Cloud* from : {&first, &second}) {
      CloudColumn column = from->columns[c];
      const std::size_t end = c + 1 < from->columns.size() ? from->columns[c + 1].first_point : from->size();
      const auto* const bytes = from->points_bytes.data();
      const std::size_t size = sizeof(CloudPoint);
      column.echo = from == &first ? 0 : 1;
      const std::size_t begin = column.first_point;
      column.first_point = static_cast<std::uint32_t>(both.size());
      both.columns.push_back(column);
      both.points_bytes.insert(both.points_bytes.end(), bytes + begin * size, bytes + end * size);
    }
  }
  return both;
}

}  // namespace lidard::test::rings
