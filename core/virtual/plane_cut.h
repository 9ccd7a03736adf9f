// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/evidence/raster.h"
#include "core/frames/scan_grid.h"
#include "core/virtual/plane_view.h"

namespace lidard {

/// Cuts the surfaces of an organised cloud with planes z = const of a virtual frame and draws the cuts into
/// the beams of a virtual scan.
///
/// Ballardini et al. ("ira_laser_tools: a ROS LaserScan manipulation toolbox", arXiv:1411.1086, 2014) project
/// the points near the plane; here the plane cuts the surfaces between the points.
///
///    ring r + 1   b------b'      Four neighbouring returns (two rings, two columns) span two triangles, if
///                 |     /|       they lie on one surface. An edge whose ends a, b are at heights h_a, h_b
///    plane  ======x===x==x===    on either side of the plane is crossed at the share
///                 | /    |           t = h_a / (h_a - h_b)
///    ring r       a------a'      of the way from a to b; crossings x of one surface are joined.
///
/// Where the ground is known, objects reach down to it: the edge between a return from the ground and the
/// return above it is not a surface, and the surface of the upper return ends on the ground unless a beam
/// passed beneath it. Edges between two returns from the ground are not drawn.
class PlaneCut {
 public:
  /// Draws the cut with the view's plane; `tops` belong to that plane.
  void draw_slice(const PlaneView& view, const PlaneTops& tops, const Raster& raster, RangeLayer& layer);
  /// Draws the parts of the cloud between two heights of the view's frame: lines between neighbouring returns
  /// of one surface, clipped to the band, and single returns. draw_slice() draws the cuts with the band's
  /// limits.
  void draw_edges(const PlaneView& view, HeightBand band, const Raster& raster, RangeLayer& layer);

 private:
  /// Where the plane crosses the surface between a ring and the one beneath it.
  struct Crossing {
    Raster::Point at{};
    Raster::Point neighbour{};  // at the other end of the newest segment
    std::uint32_t ring = 0;     // the upper one
    bool foot = false;          // the crossing is the foot of the upper return on the ground
    std::uint8_t segments = 0;
  };
  /// A point in the virtual frame; `beam` is its azimuth in beams of the virtual scan.
  struct PlanePoint {
    Raster::Point point;
    float beam;
  };
  /// The surface between two returns of neighbouring rings. `top`: the lower return is on the face of an
  /// object, the upper one on its top. `nothing`: the returns are on separate faces.
  enum class Between : std::uint8_t { slope, top, nothing };
  struct Line {
    Raster::Point from, to;
  };
  static constexpr std::size_t no_crossing = static_cast<std::size_t>(-1);

  void find_events();
  void cross(std::size_t column, std::size_t ring);
  void add(const Raster::Point& at, std::size_t ring, bool foot);
  bool passes_beneath(std::size_t lower, std::size_t upper) const;
  bool has_foot(std::size_t upper, std::size_t upper_ring) const;
  Between between_rings(std::size_t column, std::size_t upper) const;
  bool cross_level(std::size_t column, std::size_t ring, PlanePoint& at) const;
  bool turns_between(std::size_t column) const;
  void connect(std::size_t column);
  void connect_turning(std::size_t column);
  bool go_together(std::size_t column, const Crossing& left, const Crossing& right) const;
  PlanePoint point_of(std::size_t crossing) const { return {crossings_[crossing].at, beams_[crossing]}; }
  void join(std::size_t a, const PlanePoint& at_a, std::size_t b, const PlanePoint& at_b);
  void flush(std::size_t crossing) const;
  void add_clipped(std::size_t a, std::size_t b, float low, float high);
  void add_edges(std::size_t column, HeightBand band);

  // Of the current cut.
  const PlaneView* view_ = nullptr;
  const PlaneTops* tops_ = nullptr;
  const Raster* raster_ = nullptr;
  RangeLayer* layer_ = nullptr;

  std::vector<std::uint8_t> events_;   // by index(): a surface may cross the plane beneath this beam
  std::vector<Crossing> crossings_;    // by column and ring
  std::vector<std::uint32_t> firsts_;  // per column, and the end
  std::vector<Line> lines_;            // of a band
  std::vector<float> x_, y_, beams_;   // of the crossings, or the ends of the lines
};

}  // namespace lidard
