// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/evidence/visibility.h"
#include "core/frames/scan_grid.h"
#include "core/virtual/plane_view.h"

namespace lidard {

/// The evidence of an organised cloud's beams for a plane of a virtual frame.
///
///      S                    A beam from the sensor S, H above the plane (===), whose end E is at height h
///      |`-._                (h < H) and e m away (level), crosses the plane, or would, at
///    H |    `-._                a = e H / (H - h).
///    ==+========`x===       The plane is free there if h < 0: the beam goes on to E beneath.
///      |--- a ---| `-.E
///
/// The piece between two neighbouring beams of a column that both cross the plane counts as free, unless the
/// lower beam hits an object that may reach the plane. Between a crossing beam and a next one that hits an
/// object, the piece is free up to the object. The part nearer than the nearest crossing and the nearest
/// object is blind: no beam can see it. Pieces of neighbouring columns that overlap are one outline.
///
/// A lone return hides nothing: its beam counts as the one by which it is shown.
class CutEvidence {
 public:
  /// Adds the outlines of a lidar's evidence for the view's plane; `tops` belong to that plane. Free pieces
  /// end at objects between the heights of `band` (returns from the ground excluded).
  void find(const PlaneView& view, const PlaneTops& tops, HeightBand band, std::size_t lidar,
            Visibility& visibility);

 private:
  using OutlineBeam = Outlines::Beam;
  /// What is known of a beam. `hits`: a return; `stands`: one that is not ground. `crosses`: the beam crosses
  /// the plane.
  enum Mark : std::uint8_t { known = 1, crosses = 2, hits = 4, stands = 8, lone = 16 };
  /// Where the view of a beam ends.
  struct End {
    float at;  // m, level in the plane; infinite: nowhere
    bool hides;
  };
  /// A piece of a column's way through the plane.
  struct Piece {
    float from;  // m, level
    End end;
    std::size_t first, last;  // the beams that begin and end it, RingGrid::index()
  };
  /// Pieces of neighbouring columns with one outline.
  struct Strip {
    std::vector<OutlineBeam> beams;
    Piece newest{}, next{};  // of the column before, and of the current one
    Outlines::Side begin = Outlines::Side::other;
    bool goes_on = false;     // in the current column
    bool has_branch = false;  // to it
  };
  struct Strips {
    std::vector<Piece> column;  // the pieces of the current column
    std::vector<Strip> open;    // the first `count` of them
    std::size_t count = 0;
  };

  void look_from(const BeamEnd& origin);
  void measure_column(std::size_t column);
  void show_lone_return(const RingLinks::LoneReturn& one);
  /// m, level from where the column began to a point.
  float reach_of(const Raster::Point& end) const {
    const float x = end.x - at_.x, y = end.y - at_.y;
    return std::sqrt(x * x + y * y);
  }
  /// The k-th ring, in order away from the sensor's foot.
  std::size_t ring(std::size_t k) const { return nearest_ring_ + static_cast<std::size_t>(step_) * k; }
  std::uint8_t verdict(std::size_t ring) const { return tops_->verdicts()[base_ + ring]; }
  bool find_column(std::size_t column);
  void end_piece(std::size_t first, std::size_t last, std::size_t next, End thing);
  End end_at(std::size_t ring) const;
  End thing_at(std::size_t last, std::size_t next) const;
  void add(Visibility::Kind kind, float from, std::size_t first, std::size_t along, End end);
  bool transform(const Piece& piece, OutlineBeam& way) const;
  bool direct(std::size_t beam, float& ux, float& uy) const;
  void add_blind(std::size_t lowest);
  float wall_in_band() const;
  float whole_band_from() const;

  void join_column();
  void join_column(Visibility::Kind kind);
  bool are_joined(const Piece& a, const Piece& b, Visibility::Kind kind) const;
  bool is_straight(const Piece& a, const Piece& b, Visibility::Kind kind) const;
  void begin_strip(Strips& strips, const Piece& piece, Outlines::Side begin) const;
  void end_strips(Visibility::Kind kind);
  void close_circle();
  void add_strip(Visibility::Kind kind, std::vector<OutlineBeam>& beams, Outlines::Side begin,
                 Outlines::Side end);

  // Of the current call of find().
  const PlaneView* view_ = nullptr;
  const PlaneTops* tops_ = nullptr;
  Visibility* visibility_ = nullptr;
  std::size_t lidar_ = 0;
  HeightBand band_;
  std::size_t rings_ = 0;
  Raster::Point at_{};            // m, the sensor in the frame, when it fired the current column
  float reach_ = 0;               // m
  float sensor_ = 0;              // m, its distance from the plane
  float sign_ = 1;                // -1: the sensor is beneath the plane
  std::ptrdiff_t step_ = 1;       // from a beam to the next one away from the sensor's foot
  std::size_t nearest_ring_ = 0;  // to the sensor's foot
  bool clockwise_ = false;        // order of the columns
  bool tilted_ = false;           // the beams of a column have different directions in the plane
  const RingLinks::LoneReturn* lone_ = nullptr;  // the first one of the columns that follow
  const RingLinks::LoneReturn* lone_end_ = nullptr;
  // Of the current column, by ring.
  std::size_t base_ = 0;  // RingGrid::index() of the first ring
  std::vector<std::uint8_t> marks_;
  std::vector<float> ends_;       // m, e of the drawing
  std::vector<float> beneath_;    // m, of the end, beyond the plane as seen from the sensor
  std::vector<float> crossings_;  // m, a of the drawing: where the beam crosses the plane or would cross it
  float farthest_ = 0;            // m, nearest object in the band
  float looked_from_ = 0;         // m, whole_band_from()

  std::array<Strips, Visibility::kinds> strips_;
  Outlines::Side begin_side_ = Outlines::Side::other;  // of strips that begin in the current column
  Outlines::Side end_side_ = Outlines::Side::other;    // of those that do not go on in it
  OutlineBeam way_;                                    // of the current piece
  std::vector<OutlineBeam> pair_;
};

}  // namespace lidard
