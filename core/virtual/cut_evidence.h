// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/evidence/free_space_map.h"
#include "core/frames/scan_grid.h"
#include "core/virtual/plane_view.h"

namespace lidard {

/// What the beams of an organised cloud prove of a plane of a virtual frame.
///
///      S                    A beam from the sensor S, H above the plane (===), whose end E is at height h
///      |`-._                (h < H) and e m away (level), crosses the plane, or would, at
///    H |    `-._                a = e H / (H - h).
///    ==+========`x===       The plane is free there if h < 0: the beam goes on to E beneath.
///      |--- a ---| `-.E
///
/// A beam proves the plane free only where it crosses it before its return. Two neighbouring beams of a
/// column that both cross it bound a piece of the plane that is taken to be free; so do a beam that crosses
/// it and the next one up to where that one meets something. Nearer than the nearest crossing no beam can
/// see: blind.
class CutEvidence {
 public:
  /// Free pieces that are kept of each direction: the nearest one, and one beyond something.
  static constexpr std::size_t pieces = 2;

  /// Finds the evidence for the view's plane, in which `tops` were found. Free pieces end where something
  /// stands between the heights of `band` (of all returns but those from the ground). The maps must have
  /// been set to the sensor's place; they are filled.
  void find(const PlaneView& view, const PlaneTops& tops, HeightBand band,
            const std::array<FreeSpaceMap*, pieces>& free, FreeSpaceMap& blind);

 private:
  struct Piece {
    float from = 0, to = -1;
    bool exists() const { return to >= from; }
  };
  struct Cell {
    std::array<Piece, pieces> free{};
    float blind = 0;
  };
  /// Cells all around, counted from a turn ahead so that none is negative.
  struct Cells {
    std::size_t first = 1, last = 0;
  };
  /// What a beam is to the plane.
  enum Mark : std::uint8_t { known = 1, crosses = 2 };
  /// A beam as the plane sees it; `at` is a of the drawing, `end` is e.
  struct Ray {
    float x = 0, y = 0;  ///< towards its end
    float end = 0;       ///< m, level in the plane, where it ends
    float at = 0;        ///< m, level in the plane, where it crosses or would
  };
  /// A free piece between neighbouring beams; nearer than `blind` no beam of its column sees the plane.
  struct Wedge {
    float from, to;
    float blind;
    float x, y;   // towards the beam that it is seen along
    float begin;  // cells, where the plane leans the azimuth of the beam it begins with
  };

  void mark_beams();
  Ray ray(std::size_t i) const;
  void add(const Ray& first, const Ray& seen_along, float to);
  void add_blind(const Ray& lowest);
  /// Of the beams of a column, in order away from the sensor's foot, the k-th.
  std::size_t beam(std::size_t base, std::size_t k) const { return base + (sign_ > 0 ? k : rings_ - 1 - k); }
  void find_wedges(std::size_t column);
  void end_wedge(const Ray& first, std::size_t last, std::size_t next);
  void take_wedges();
  void take_tilted(const Wedge& wedge, float azimuth);
  Cells cells_at(float azimuth) const;
  bool is_hidden(std::size_t before, std::size_t upper) const;
  float wall_in_band(std::size_t column) const;
  void claim(Cells cells, float from, float to);
  void claim(Cell& cell, float from, float to) const;
  Cell& cell(std::size_t counted) {
    const std::size_t turn = cells_.size();
    return cells_[counted >= 2 * turn ? counted - 2 * turn : counted >= turn ? counted - turn : counted];
  }
  void fill_holes();

  std::vector<Cell> cells_;
  std::vector<std::uint8_t> marks_;  // by RingGrid::index()
  float width_ = 1;                  // of a column, in cells
  std::vector<Wedge> wedges_;
  std::vector<float> x_, y_, azimuths_;  // of the wedges
  std::size_t rings_ = 0;
  const BeamEnd* ends_ = nullptr;
  std::array<float, 6> axes_{};  // of the frame's x and y in the cloud's frame
  float blind_ = 0;              // m, of the next wedge
  float farthest_ = 0;           // m, where something stands in the column at hand
  const PlaneView* view_ = nullptr;
  const PlaneTops* tops_ = nullptr;
  float sensor_ = 0;  // m above the plane, turned so that it is positive
  float sign_ = 1;
  HeightBand band_;
  float per_rad_ = 1;  // cells
  bool tilted_ = false;
};

}  // namespace lidard
