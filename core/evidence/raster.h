// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/evidence/placed_scan.h"
#include "core/frames/scan_grid.h"

namespace lidard {

/// The nearest thing in each beam of an output scan; infinite range: nothing.
struct RangeLayer {
  std::vector<float> range;  ///< m
  std::vector<float> intensity;
  void clear(std::size_t beams);
};

/// Draws surfaces into the beams of an output scan, as a scanner at the output frame's origin would measure
/// them. A beam keeps the range of the nearest surface.
class Raster {
 public:
  using Point = PlacedScan::Point;

  explicit Raster(const ScanGrid& grid);

  const ScanGrid& grid() const { return grid_; }
  float cosine(std::size_t beam) const { return cosine_[beam]; }
  float sine(std::size_t beam) const { return sine_[beam]; }
  /// Number of beams in a full turn.
  float turn() const { return turn_; }

  /// Draws all surfaces of a sweep. Ends of surfaces and single returns also count in the beam nearest to
  /// them.
  void draw(const PlacedScan& sweep, RangeLayer& layer);
  /// Draws the mixed pixels of a sweep as points.
  void draw_mixed_pixels(const PlacedScan& sweep, RangeLayer& layer) const;
  void draw_point(Point p, RangeLayer& layer) const;
  void draw_segment(const Point& p, const Point& q, RangeLayer& layer) const;
  /// Beams from the first one to the azimuth of (x, y), in [0, turn()).
  float position(float x, float y) const;
  /// The positions of `count` points.
  void positions(const float* x, const float* y, std::size_t count, float* at) const;
  /// draw_point() and draw_segment() with known positions.
  void draw_point(Point p, float at, RangeLayer& layer) const;
  void draw_segment(const Point& p, const Point& q, float at_p, float at_q, RangeLayer& layer) const;
  /// Draws the end `p` of a surface that comes from `inner` into the beam nearest to it.
  void draw_end(Point p, Point inner, float at, RangeLayer& layer) const;

 private:
  std::size_t nearest_beam(float at) const;
  void fill(const Point& p, const Point& q, std::size_t first, float to, RangeLayer& layer) const;

  ScanGrid grid_;
  float turn_;     // beams
  float per_rad_;  // beams
  float first_;    // rad
  std::vector<float> cosine_;
  std::vector<float> sine_;
  std::vector<float> positions_;  // of the returns of one sweep
};

}  // namespace lidard
