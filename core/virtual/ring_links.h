// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/virtual/ring_grid.h"

namespace lidard {

/// Which neighbouring returns of an organised cloud lie on one surface: the rule of planar scans
/// (link_neighbours() in core/evidence/placed_scan.h) for neighbours in a ring and in a column.
class RingLinks {
 public:
  /// The grid must stay alive. `noise`: one standard deviation of a range, m.
  void set(const RingGrid& grid, double noise);

  /// A return (a drop, a leaf) beside which on all four sides, in its ring and in its column, one of the next
  /// two beams goes on far beyond. `shown_by`: the nearer one of these in the ring.
  struct LoneReturn {
    std::size_t beam, shown_by;  // RingGrid::index()
  };
  /// By beam.
  const std::vector<LoneReturn>& lone_returns() const { return lone_returns_; }

  /// Links return `ring` of `column` with that of the next column; level_at(): by RingGrid::index().
  bool level(std::size_t column, std::size_t ring) const { return level_at(grid_->index(column, ring)); }
  bool level_at(std::size_t i) const {
    if (levels_[i] == Link::not_asked) levels_[i] = is_level(i) ? Link::linked : Link::apart;
    return levels_[i] == Link::linked;
  }
  /// Links return `ring` of `column` with that of the next ring.
  bool upright(std::size_t column, std::size_t ring) const;
  /// True if three returns lie on one line.
  bool in_line(std::size_t a, std::size_t b, std::size_t c) const;
  /// m, one standard deviation of a range, and three of them.
  float noise() const { return slack_ / 3; }
  float slack() const { return slack_; }

 private:
  enum class Link : std::uint8_t { not_asked, apart, linked };

  bool is_point(std::size_t i) const { return grid_->kind[i] == Beam::point; }
  Eigen::Vector3f end(std::size_t i) const {
    const BeamEnd& at = grid_->ends[i];
    return {at.x, at.y, at.z};
  }
  bool near(std::size_t a, std::size_t b, float slope) const {
    const float limit = std::min(grid_->range[a], grid_->range[b]) * slope + slack_;
    const BeamEnd p = grid_->ends[a];
    const BeamEnd q = grid_->ends[b];
    return (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y) + (p.z - q.z) * (p.z - q.z) <= limit * limit;
  }
  bool is_level(std::size_t i) const;
  bool grazing_level(std::size_t column, std::size_t ring) const;
  bool grazing(std::size_t a, std::size_t b, std::size_t c, std::size_t d) const;
  void find_lone_returns();
  void mark_lone_in_ring();
  const LoneReturn* lone_return(std::size_t i) const;
  std::size_t before(std::size_t column) const { return column > 0 ? column - 1 : grid_->columns() - 1; }

  const RingGrid* grid_ = nullptr;
  float slack_ = 0;
  float level_slope_ = 0;
  std::vector<float> upright_slopes_;  // per ring, to the next one
  mutable std::vector<Link> levels_;   // answers of level(), which frames ask again and again
  std::vector<LoneReturn> lone_returns_;
  std::vector<float> lengths_;  // m, as far as a beam is known to see, with two columns on each side
  std::vector<std::uint8_t> lone_in_ring_;  // by RingGrid::index()
};

/// How ground and objects are distinguished. `plane`: ground is at most `tolerance` above z. `slope`: ground
/// is reached outward from the sensor's foot without a slope steeper than `steepest`.
enum class GroundModel : std::uint8_t { none, plane, slope };

struct GroundSettings {
  GroundModel model = GroundModel::none;
  double z = 0;            ///< m, in the vehicle's frame; with `slope`: beneath the sensor
  double tolerance = 0.1;  ///< m
  double steepest = 0.15;  ///< rise per m; with `slope`
};

/// The ground of one cloud, shared by all frames that are cut from it.
struct Ground {
  bool known = false;
  /// `rise`: ground of a slope that no farther return of the column confirms. It is no surface of an object,
  /// but proves nothing free: it may be the face of a low thing.
  enum Kind : char { none, sure, rise };
  std::vector<char> is_ground;  ///< Kind, by RingGrid::index()
  std::vector<float> height;    ///< m above z
  std::vector<float> distance;  ///< m from the sensor, level
  float sensor = 0;             ///< m, the sensor's height above z
};

/// Finds the returns from the ground in `grid`.
void find_ground(const RingGrid& grid, const GroundSettings& settings, const Pose& vehicle_from_cloud,
                 Ground& ground);

}  // namespace lidard
