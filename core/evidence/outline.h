// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/evidence/placed_scan.h"

namespace lidard {

/// The outlines of what several sources see to be free, as lists of vertices and directed edges in the
/// output's plane.
///
///          1----2            The outline of one sweep from its scanner S, counter-clockwise: from return to
///         /      \           return along a surface (1-2), out or in along a jump where a near return ends
///    .---0 jump   \          and a far one begins, an arc at the end of the reach of a beam without return,
///    |             3         and back along the positions from which the beams were measured.
///    |            /          Left of an edge the source sees free space. Right of it lies what a return
///    S----------o----x-->    hides (`hides`), or what nobody looked at.
///
/// What a return hides is a region, too: it reaches from the hiding edges of the outline outward to beyond
/// all ranges. Where hiding edges follow open ones, a border leads outward from the vertex between them.
/// Borders and far ends bound hidden space alone.
///
/// Between two neighbouring beams whose returns are not on one surface, the nearer return owns all of the
/// angle but the share `passed_share` beside the farther beam.
class Outlines {
 public:
  /// How the space on the two sides of an edge differs. A beam that crosses an edge counter-clockwise as seen
  /// from its begin goes from left to right.
  struct Edge {
    std::uint32_t from = 0, to = 0;  ///< vertices
    std::uint16_t source = 0;
    std::int8_t free = 0;    ///< change of the number of free layers of the source from left to right
    std::int8_t hidden = 0;  ///< the same of hidden layers
    /// The end of the edge that lies at the return which hides; none: all of the edge does.
    enum Near : std::uint8_t { both, at_from, at_to } near = both;
    bool beyond = false;  ///< it lies beyond all ranges
  };

  static constexpr std::uint32_t none = 0xFFFFFFFF;
  /// A beam, or a part of one, that is free from its begin to its end.
  struct Beam {
    float x = 0, y = 0;    ///< m, end of the free way
    float ox = 0, oy = 0;  ///< m, the position from which the source looks
    float ux = 0, uy = 0;  ///< direction, 1 m
    float length = 0;      ///< m, from that position to the end; 0: no evidence
    float from = 0;        ///< m, from that position to where the free way begins
    float bx = 0, by = 0;  ///< m, where it begins
    bool hides = false;    ///< a return stands at its end
    bool to_next = false;  ///< the free space reaches straight from this end to that of the next beam
    const PlacedScan::Point* corner = nullptr;  ///< the straight way bends there
    std::uint32_t vertex = none;                ///< at its end, as soon as there is one
  };
  /// What the first or last beam of a strip borders on: beams that nobody fired, beams that see something
  /// else, or the strip that goes on there.
  enum class Side : std::uint8_t { unknown, other, joined };

  void clear();
  /// Sets the share of the angle between a near return and a beam that passes it which counts as passed, and
  /// m beyond all ranges of the output as seen from every source.
  void set_source(std::size_t source, float passed_share, float reach);
  std::size_t source() const { return source_; }
  /// Adds the outline of a sweep.
  void add_sweep(const BeamRays& rays, const PlacedScan& sweep);
  /// Adds the outline of beams in counter-clockwise order, neighbours all. It extends by half a step on an
  /// `unknown` side, by the passed share of a step on an `other` one, and ends in the beam on a `joined` one.
  /// Drops beams of the list that add nothing.
  void add_strip(std::vector<Beam>& beams, float step, Side begin, Side end);
  /// Adds a polygon that is free inside: the vehicle.
  void add_polygon(std::size_t source, const Footprint& polygon);

  std::vector<float> x, y;  ///< of the vertices; m, output frame
  std::vector<Edge> edges;

 private:
  /// A vertex on the outer side of a run, in the direction u of the scanner, and the edge to the next vertex.
  struct Link {
    std::uint32_t vertex;
    float ux, uy;
    float bx, by;  // m, begin of the beam
    bool hides;
    Edge::Near near;
  };

  std::uint32_t add_vertex(float at_x, float at_y);
  Edge& add_edge(std::uint32_t from, std::uint32_t to, int free, int hidden);
  void drop_needless_beams(std::vector<Beam>& beams) const;
  void read_beams(const BeamRays& rays, const PlacedScan& sweep);
  static void transform_beam(const BeamRays& rays, const PlacedScan& sweep, std::size_t i, float reach,
                             Beam& beam);
  /// Beam k, counted counter-clockwise and on beyond a full circle.
  Beam& beam(std::size_t k) const { return beams_[k < count_ ? k : k - count_]; }
  /// Link k of the chain, which may count on beyond its end.
  const Link& link(std::size_t k) const { return chain_[k < chain_.size() ? k : k - chain_.size()]; }
  bool joins(std::size_t a, std::size_t b) const;
  bool closes_circle() const;
  void add_run(std::size_t first, std::size_t end, bool closed, float begin_share, float end_share);
  std::uint32_t vertex_of(std::size_t k);
  void add_end(std::size_t first, std::size_t end, bool begins, float share);
  void add_pair(std::size_t k);
  void push(std::uint32_t vertex, const Beam& beam, bool hides, Edge::Near near = Edge::both);
  void add_inner_side(std::size_t first, std::size_t end, bool closed);
  template <class Lead>
  void lead_along_border(const Beam& a, const Beam& b, Lead lead_to);
  void add_hidden(bool closed);
  void add_far_side(std::size_t first, std::size_t last);
  void pass_lone_return(std::size_t k);

  // Of the source whose outlines are added.
  std::uint16_t source_ = 0;
  float passed_share_ = 0, reach_ = 0;
  float step_ = 0;           // rad between beams
  bool moved_ = false;       // the beams began in different positions
  std::vector<Beam> sweep_;  // the beams of a sweep
  Beam* beams_ = nullptr;    // of the sweep or strip
  std::size_t count_ = 0;
  std::vector<Link> chain_;  // the outer side of the current run
};

}  // namespace lidard
