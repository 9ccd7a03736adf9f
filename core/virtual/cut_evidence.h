// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
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
/// A beam proves the plane free only where it crosses it before its return, and where its neighbours in the
/// ring do so too: what stands between two columns may go on as far as to the one that misses it. Two
/// neighbouring beams of a column that both cross the plane bound a piece of it that is taken to be free,
/// unless the lower one meets something that may reach the plane; so do a beam that crosses it and the next
/// one up to where that one meets something. Nearer than the nearest crossing, and than what stands there, no
/// beam can see: blind.
class CutEvidence {
 public:
  /// Free pieces that are kept of each direction: the nearest one, and one beyond something.
  static constexpr std::size_t pieces = 2;

  /// Finds the evidence for the view's plane, in which `tops` were found. Free pieces end where something
  /// stands between the heights of `band` (of all returns but those from the ground). `over`: ways over
  /// things that end between two beams and more likely than not beneath the plane. The maps must have been
  /// set to the sensor's place; they are filled.
  void find(const PlaneView& view, const PlaneTops& tops, HeightBand band,
            const std::array<FreeSpaceMap*, pieces>& free, FreeSpaceMap& blind, FreeSpaceMap& over);

 private:
  /// `hides`: a return stands at `to`.
  struct Piece {
    float from = 0, to = -1;
    bool hides = false;
    bool exists() const { return to >= from; }
    bool is_shorter(const Piece& other) const { return to < other.to || (to == other.to && hides); }
  };
  struct Cell {
    std::array<Piece, pieces> free{};
    Piece blind{}, over{};
  };
  /// Cells all around, counted from a turn ahead so that none is negative.
  struct Cells {
    std::size_t first = 1, last = 0;
  };
  /// What a beam is to the plane. `meets`: it crosses the plane, and it or a neighbour in the ring meets a
  /// thing beyond.
  enum Mark : std::uint8_t { known = 1, crosses = 2, meets = 4 };
  /// A beam as the plane sees it; `at` is a of the drawing, `end` is e.
  struct Ray {
    float x = 0, y = 0;  ///< towards its end
    float end = 0;       ///< m, level in the plane, where it ends
    float at = 0;        ///< m, level in the plane, where it crosses or would
  };
  /// A free piece between neighbouring beams; nearer than `blind` no beam of its column sees the plane.
  struct Wedge {
    Piece free, blind, over;
    float x, y;   // towards the beam that it is seen along
    float begin;  // cells, where the plane leans the azimuth of the beam it begins with
  };
  /// Where what neighbouring beams meet ends what a beam sees.
  struct End {
    float at;  // m, level in the plane; infinite: nowhere
    bool hides;
  };

  void mark_beams();
  /// Marks `count` beams as far as the ones before and after them in their rings agree.
  static void agree(const std::uint8_t* own, const std::uint8_t* before, const std::uint8_t* after,
                    std::uint8_t* marks, std::size_t count);
  Ray ray(std::size_t i) const;
  void add(const Ray& first, const Ray& seen_along, End end);
  void add_blind(std::size_t lowest);
  /// A beam and its two neighbours in the ring.
  std::array<std::size_t, 3> abreast(std::size_t i) const;
  bool on_one_surface(std::size_t i, std::size_t beside) const;
  /// The nearest end of those of them that do not cross the plane.
  End end_abreast(std::size_t i) const;
  /// Where a thing stands that one of three crossing beams meets and that may reach the plane under the next
  /// beams of their columns; `step` leads to those.
  End thing_abreast(std::size_t last, std::ptrdiff_t step) const;
  /// Of the beams of a column, in order away from the sensor's foot, the k-th.
  std::size_t beam(std::size_t base, std::size_t k) const { return base + (sign_ > 0 ? k : rings_ - 1 - k); }
  void find_wedges(std::size_t column);
  void end_wedge(const Ray& first, std::size_t last, std::size_t next);
  bool is_hidden(std::size_t before, std::size_t upper) const;
  void take_wedges();
  void take_tilted(const Wedge& wedge, float azimuth);
  Cells cells_at(float azimuth) const;
  float wall_in_band(std::size_t column) const;
  void claim(Cells cells, const Piece& piece);
  void claim(Cell& cell, const Piece& piece) const;
  Cell& cell(std::size_t counted) {
    const std::size_t turn = cells_.size();
    return cells_[counted >= 2 * turn ? counted - 2 * turn : counted >= turn ? counted - turn : counted];
  }
  void fill_holes();

  std::vector<Cell> cells_;
  std::vector<std::uint8_t> own_marks_;  // by RingGrid::index(): of the beam alone
  std::vector<std::uint8_t> marks_;      // and as far as its neighbours in the ring agree
  float width_ = 1;                      // of a column, in cells
  std::vector<Wedge> wedges_;
  std::vector<float> x_, y_, azimuths_;  // of the wedges
  std::size_t rings_ = 0;
  const BeamEnd* ends_ = nullptr;
  std::array<float, 6> axes_{};  // of the frame's x and y in the cloud's frame
  Piece blind_{};                // of the next wedge
  float farthest_ = 0;           // m, where something stands in the column at hand
  const PlaneView* view_ = nullptr;
  const PlaneTops* tops_ = nullptr;
  float sensor_ = 0;  // m above the plane, turned so that it is positive
  float sign_ = 1;
  float corner_ = 0;         // of its range by which a thing may be nearer than its last return, beside that
  std::ptrdiff_t step_ = 1;  // from a beam to the next one away from the sensor's foot
  HeightBand band_;
  float per_rad_ = 1;  // cells
  bool tilted_ = false;
};

}  // namespace lidard
