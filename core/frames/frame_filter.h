// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/counters.h"
#include "core/frames/cloud.h"
#include "core/frames/scan.h"

namespace lidard {

/// What becomes of a return.
enum class FilterVerdict : std::uint8_t { kept, intensity, box, voxel, outlier };

/// A box along the axes of the sensor's frame, m.
using FilterBox = Eigen::AlignedBox3d;

/// Finds outliers among `count` points: sets inliers[i] to 1 if at least `neighbours` others are within
/// `radius` m of point i, else to 0.
using FindInliers = void (*)(const CloudPoint* points, std::size_t count, double radius, int neighbours,
                             std::uint8_t* inliers);

struct FrameFilterSettings {
  std::optional<double> intensity_min;  ///< device units
  std::optional<FilterBox> box;         ///< returns outside are removed
  std::optional<FilterBox> cut_out;     ///< returns inside are removed
  double voxel_size = 0;       ///< m; of the returns in a cube the one nearest to its centre stays; 0: all
  double outlier_radius = 0;   ///< m; 0: outliers stay
  int outlier_neighbours = 2;  ///< a return with fewer of them within outlier_radius is an outlier
  FindInliers find_inliers = nullptr;  ///< not nullptr where outlier_radius is above 0

  bool any() const { return intensity_min || box || cut_out || voxel_size > 0 || outlier_radius > 0; }
};

/// What a filter did since the start.
struct FilterCounters {
  std::uint64_t returns = 0;  ///< examined
  std::uint64_t by_intensity = 0, by_box = 0, by_voxel = 0, outliers = 0;
  std::uint64_t emptied_in_a_row = 0;  ///< the newest frames, one after the other, that lost all returns
  bool has_no_intensities = false;  ///< the limit of the intensity could not be applied to the newest frame
};
/// Returns removed, by reason.
constexpr NamedCounter<FilterCounters> filter_counters[] = {
    {&FilterCounters::by_intensity, "filtered_by_intensity", "by intensity"},
    {&FilterCounters::by_box, "filtered_by_box", "by box"},
    {&FilterCounters::by_voxel, "filtered_by_voxel", "by voxel"},
    {&FilterCounters::outliers, "filtered_outliers", "outliers"}};

/// Removes returns from frames. What stays is as it was measured: neither moved nor averaged, and with its
/// ring and time. The limit of intensity comes first, then the boxes, the voxels and the outliers: each
/// examines what the former ones left. No allocation after the largest frame, except in find_inliers.
class FrameFilter {
 public:
  explicit FrameFilter(const FrameFilterSettings& settings) : settings_(settings) {}

  /// Columns of the cloud may become empty.
  void apply(Cloud& cloud);
  /// A beam that loses a return keeps its further echoes; one that loses all of them is `invalid`.
  void apply(PlanarScan& scan);
  const FilterCounters& counters() const { return counters_; }

 private:
  void judge(const CloudPoint* points, std::size_t count, bool with_intensities);
  FilterVerdict judge(const CloudPoint& point, bool with_intensities) const;
  void judge_voxels(const CloudPoint* points);
  void judge_outliers(const CloudPoint* points);
  void count(std::size_t returns);

  FrameFilterSettings settings_;
  FilterCounters counters_;
  std::vector<FilterVerdict> verdicts_;  // one per return
  std::vector<CloudPoint> points_;       // the returns of a scan
  /// A return that is still there: its voxel, the square of its distance from the voxel's centre, its index.
  struct Candidate {
    std::uint64_t voxel;
    float off_centre;
    std::uint32_t index;
  };
  std::vector<Candidate> candidates_;
  std::vector<CloudPoint> left_;  // the points of the candidates
  std::vector<std::uint8_t> inliers_;
};

}  // namespace lidard
