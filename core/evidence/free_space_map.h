// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/evidence/placed_scan.h"

namespace lidard {

/// A polar map of how far one source sees in each direction, stored as integers that compare quickly. Cells
/// are equal parts of the full circle around the source's place in the output's plane; the beams of the
/// source need not be evenly spaced.
///
///      cell k:  from ..... to          A beam of the output that starts elsewhere (o) crosses the cells of
///         \                 .          a source (S) one after the other. A point of it, d m from S in the
///          \          ...../           direction of cell k, is free if from <= d <= to:
///           S----------o---x-->
///
/// Between two linked returns at ranges a and b, on a straight surface, the inverse of the range changes
/// (nearly) evenly with the angle: at the share t of the way from a to b
///     1 / r(t) = (1 - t) / a + t / b,  so  r(t) = a b / (b + t (a - b)).
class FreeSpaceMap {
 public:
  /// m, the unit of distance of a map that reaches `range_max` (m) from the output's origin. A source may
  /// stand at most 100 m from the origin.
  static constexpr double unit_for(double range_max) { return (range_max + 100) / 60000; }

  static std::int16_t ordered(std::uint16_t distance) {
    return static_cast<std::int16_t>(distance ^ 0x8000U);
  }

  /// The distances at which a cell or all of several neighbouring cells are free. Both limits are signed
  /// numbers in the same order and `to` is inverted, so that the intersection of two runs is their maximum.
  struct Run {
    std::int16_t from = ordered(0xFFFF);
    std::int16_t not_to = static_cast<std::int16_t>(~ordered(0xFFFF));
    std::uint16_t to() const { return static_cast<std::uint16_t>(~not_to ^ 0x8000); }
    bool is_free(std::uint16_t distance) const {
      return from <= ordered(distance) && not_to <= ~ordered(distance);
    }
  };
  /// A run of cells as two entries of runs() that cover it together.
  struct RunAt {
    std::uint32_t first = 0, second = 0;
  };

  /// A point of the output's plane in polar coordinates of the source.
  struct Place {
    std::uint16_t cell;
    std::uint16_t distance;  ///< units
  };

  /// Sets the place of a source, m in the output's plane, and clears the map. Cells divide `beam_width` (rad
  /// between beams) evenly; `unit` is the unit of distance, m.
  void set(float x, float y, double beam_width, double unit);
  /// Sets place and directions of a scanner whose beams are `rays`. `narrowest` (rad) is the width of objects
  /// that may be missed: an object ends at least a quarter of that before a beam that passes it.
  void set_source(const BeamRays& rays, double unit, double narrowest = 0) {
    const Eigen::Vector3d at = rays.pose.translation();
    set(static_cast<float>(at.x()), static_cast<float>(at.y()), rays.increment, unit);
    passed_share_ = static_cast<float>(std::min(0.5, narrowest / 4 / std::abs(rays.increment)));
    place_beams(rays.x.data(), rays.y.data(), rays.size());
  }
  /// Sets the directions of the source's beams in the output's plane, in order. Call it before fill() and
  /// whenever the directions change.
  void place_beams(const float* dx, const float* dy, std::size_t beams);

  /// Fills the map from a sweep. Free ranges are interpolated between linked returns. Between other returns
  /// the object that the shorter beam hits may extend to the longer beam. Beside a beam without return the
  /// nearer beam counts.
  void fill(const PlacedScan& sweep);
  /// Removes all evidence.
  void clear();
  /// Sets the free distances of a cell, m from the source, and whether a return `hides` what is beyond;
  /// replaces earlier evidence.
  void claim(std::size_t cell, float from, float to, bool hides = false) {
    runs_[cell] = run_of(from, to);
    hides_[cell] = hides ? 1 : 0;
  }

  /// Computes the runs of several cells.
  void find_runs();
  /// Begins with the cells.
  const Run* runs() const { return runs_.data(); }
  /// Finds the run of `length` cells from `cell` on (with wrap-around) in runs(); false if the run is too
  /// long.
  bool find_run(std::size_t cell, std::size_t length, RunAt& at) const;

  float x() const { return x_; }
  float y() const { return y_; }
  /// The cell in direction (dx, dy) of the output frame from the source.
  std::uint16_t cell_towards(float dx, float dy) const;
  std::uint16_t distance(float meters) const {
    const float units = meters * per_meter_;
    // lround would keep the loops over many points from being vectorised; distances are not negative.
    // NOLINTNEXTLINE(bugprone-incorrect-roundings)
    return units < 65534.0F ? static_cast<std::uint16_t>(units + 0.5F) : std::uint16_t{65534};
  }
  /// True if something is known to be free in that direction.
  bool has_evidence(Place at) const { return runs_[at.cell].from != ordered(0xFFFF); }
  bool is_free(Place at) const { return runs_[at.cell].is_free(at.distance); }
  /// True if the straight way between two places is free. Needs up-to-date runs().
  bool is_free(Place a, Place b) const {
    const std::size_t cell = std::min(a.cell, b.cell);
    const std::size_t length = std::max(a.cell, b.cell) - cell + 1;
    if (length > longest_run) return is_free_between(a, b);
    const RunAt run = run_at(cell, length);
    const Run one = runs_[run.first], other = runs_[run.second];
    const std::int16_t from = std::max(one.from, other.from);
    if (from > ordered(std::min(a.distance, b.distance))) return false;
    if (std::max(one.not_to, other.not_to) > ~ordered(std::max(a.distance, b.distance))) return false;
    return length <= 2 || from == ordered(0) || is_free_between(a, b);
  }
  /// m from a return that hides a part of the way between two places to the nearer end of that way; the
  /// smallest such distance, infinite if no return hides a part.
  float hidden_by(Place a, Place b) const;
  /// The place of a point of the output frame, m.
  Place place_of(float x, float y) const {
    const float dx = x - x_, dy = y - y_;
    return {cell_towards(dx, dy), distance(std::sqrt(dx * dx + dy * dy))};
  }
  /// The places of `count` points of the output frame.
  void find_places(const float* x, const float* y, std::size_t count, Place* places) const;
  /// 0: no source is set.
  std::size_t size() const { return hides_.size(); }

 private:
  /// A cell between a beam and the border to a neighbouring beam. The outer cells of the first and the last
  /// beam have no neighbour.
  struct Slot {
    std::uint16_t cell;
    float share;                    // 0: in the beam's own direction
    std::uint32_t beam, neighbour;  // the beam itself if there is none
    std::uint32_t link;             // PlacedScan::linked of both
  };
  // Runs have 1, 2, 4 ... cells; two runs of the longest kind make the longest run that can be found.
  static constexpr std::size_t run_lengths = 9;
  static constexpr std::size_t longest_run = 2U << (run_lengths - 1U);
  /// find_run() without the check of the length.
  RunAt run_at(std::size_t cell, std::size_t length) const {
    // The binary logarithm.
    const std::size_t power = std::min<std::size_t>(
        31U - static_cast<unsigned>(__builtin_clz(static_cast<unsigned>(length))), run_lengths - 1);
    const std::size_t first = power * (size() + longest_run) + cell;
    return {static_cast<std::uint32_t>(first),
            static_cast<std::uint32_t>(first + length - (std::size_t{1} << power))};
  }
  /// is_free() for any number of cells and ways that pass the source.
  bool is_free_between(Place a, Place b) const;
  /// The cells from `a` to `b` along the shorter arc.
  void span_of(std::uint16_t a, std::uint16_t b, std::size_t& first, std::size_t& count) const;
  /// fill() for a moving vehicle: the ends of the beams may lie in any order.
  void fill_moved(const PlacedScan& sweep);
  void limit_pair(const PlacedScan& sweep, std::size_t beam, std::size_t after, float step);
  /// A beam beside which nobody looked. `outward`: cells to the unseen side; of the result only the sign.
  struct Edge {
    float towards;  // cells from -pi, direction of the beam
    float outward;
    float aside;  // m, from the beam's line to the scanner's present place; positive on the unseen side
  };
  Edge edge_of(const PlacedScan& sweep, std::size_t beam, float outward) const;
  /// `keeps_near`: a free way that ends before the seen part stays.
  void begin_later(const Edge& edge, bool keeps_near);
  /// `hit`: direction of the return now, cells from -pi.
  void end_earlier(const Edge& edge, float hit);
  bool joins_ends(const PlacedScan& sweep) const;
  /// The cell that holds a direction at most one turn outside, cells from -pi.
  std::size_t cell_at(float direction) const {
    return inside(static_cast<std::int32_t>(std::floor(direction)));
  }
  std::size_t inside(std::int32_t cell) const {
    const auto count = static_cast<std::int32_t>(size());
    return static_cast<std::size_t>(cell < 0 ? cell + count : cell >= count ? cell - count : cell);
  }
  /// Limits the free ways in cells [begin, end] (cells from -pi; either may be the larger) to lengths that
  /// change from `a` to `b`.
  void limit(float begin, float end, float from, float a, float b, bool hides);
  void add_slots(std::size_t beam, std::size_t neighbour, std::size_t link, double at, double border);
  Run run_of(float from, float to) const;
  /// Converts starts_ and ends_ to runs.
  void set_runs();

  float x_ = 0, y_ = 0;
  float per_meter_ = 1;
  float per_rad_ = 1;            // cells
  float half_beam_ = 0;          // cells to the border to the next beam, signed
  bool closed_ = false;          // the last beam is the neighbour of the first one
  float passed_share_ = 0;       // share of the angle between two beams that belongs to the longer one
  std::vector<char> hides_;      // per cell: the free way ends at a return
  std::vector<Run> runs_;        // by length (1, 2, 4 ... cells), then by first cell
  std::vector<float> azimuths_;  // cells from -pi, of the ends of moved beams
  std::vector<float> lengths_;   // m, free ways of moved beams
  std::vector<float> begins_;    // m, where these begin
  /// Of returns that moved away from their neighbours in direction: the beam that passed, and where it is.
  std::vector<std::pair<Edge, float>> passed_;
  std::vector<float> starts_, ends_;  // m, of each cell's free way; end < 0: none
  std::vector<Slot> slots_;
};

}  // namespace lidard
