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

/// The evidence of an organised cloud's beams for a plane of a virtual frame.
///
///      S                    A beam from the sensor S, H above the plane (===), whose end E is at height h
///      |`-._                (h < H) and e m away (level), crosses the plane, or would, at
///    H |    `-._                a = e H / (H - h).
///    ==+========`x===       The plane is free there if h < 0: the beam goes on to E beneath.
///      |--- a ---| `-.E
///
/// A beam proves the plane free only if the beam and its neighbours in the ring cross the plane before their
/// returns: an object between two columns may extend to the column that misses it. The piece between two
/// neighbouring beams of a column that both cross the plane counts as free, unless the lower beam hits an
/// object that may reach the plane. Between a crossing beam and a next one that hits an object, the piece is
/// free up to the object. The part nearer than the nearest crossing and the nearest object is blind: no beam
/// can see it.
class CutEvidence {
 public:
  /// Number of free pieces per direction: the nearest one, and one beyond an object.
  static constexpr std::size_t pieces = 2;

  /// Fills the maps with the evidence for the view's plane; `tops` belong to that plane. Free pieces end at
  /// objects between the heights of `band` (returns from the ground excluded). `over`: ways over objects
  /// whose tops lie between two beams and likely beneath the plane. A free piece that begins where the blind
  /// part ends joins the blind part in `blind`: one map shows the whole way to a surface. The maps must be
  /// set to the sensor's place.
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
  /// A range of cells, offset by a turn so that no index is negative.
  struct Cells {
    std::size_t first = 1, last = 0;
  };
  /// How a beam relates to the plane. `meets`: the beam crosses the plane, and it or a neighbour in the ring
  /// hits an object beyond.
  enum Mark : std::uint8_t { known = 1, crosses = 2, meets = 4 };
  /// A beam in the plane; `at` is a of the drawing: m, level in the plane, where it crosses the plane or
  /// would cross it.
  struct Ray {
    std::size_t beam;
    float at;
  };
  /// A piece between neighbouring beams: the nearest one, and the one in whose direction the piece lies.
  struct Wedge {
    Piece piece;
    std::uint32_t first, along;  // RingGrid::index()
  };
  /// Where an object that neighbouring beams hit ends the view of a beam.
  struct End {
    float at;  // m, level in the plane; infinite: nowhere
    bool hides;
  };

  void mark_beams();
  /// Marks `count` beams whose neighbours in the ring, `before` and `after`, have the same marks.
  static void mark_agreed(const std::uint8_t* own, const std::uint8_t* before, const std::uint8_t* after,
                          std::uint8_t* marks, std::size_t count);
  Ray ray(std::size_t i) const;
  /// m, e of the drawing.
  float end_of(std::size_t i) const { return view_->reaches()[i]; }
  void add(const Ray& first, const Ray& seen_along, End end);
  void add_blind(std::size_t lowest);
  /// A beam and its two neighbours in the ring.
  std::array<std::size_t, 3> abreast(std::size_t i) const;
  bool on_one_surface(std::size_t i, std::size_t beside) const;
  /// The nearest end of those beams abreast of `i` that do not cross the plane.
  End end_abreast(std::size_t i) const;
  /// The nearest object that one of three crossing beams hits and that may reach the plane under the next
  /// beams of their columns.
  End thing_abreast(std::size_t last) const;
  /// The k-th beam of a column, in order away from the sensor's foot.
  std::size_t beam(std::size_t base, std::size_t k) const {
    return base + nearest_ring_ + static_cast<std::size_t>(step_) * k;
  }
  void find_wedges(std::size_t column);
  void end_wedge(const Ray& first, std::size_t last, std::size_t next, End thing);
  bool is_hidden(std::size_t before, std::size_t upper) const;
  /// Claims the wedges found so far.
  void claim_wedges();
  void end_at_things();
  /// Calls use(cell, piece) for all cells of non-tilted wedges.
  template <class Use>
  void each_cell(const std::vector<Wedge>& wedges, Use use);
  void claim_tilted(const Piece& piece, float begin, float azimuth);
  void find_azimuths(const std::vector<Wedge>& wedges, std::uint32_t Wedge::*beam,
                     std::vector<float>& azimuths);
  Cells cells_at(float azimuth) const;
  float wall_in_band(std::size_t column) const;
  float whole_band_from(std::size_t column) const;
  void claim(Cells cells, const Piece& piece);
  void claim(Cell& cell, const Piece& piece) const;
  Cell& cell(std::size_t counted) {
    const std::size_t turn = cells_.size();
    return cells_[counted >= 2 * turn ? counted - 2 * turn : counted >= turn ? counted - turn : counted];
  }
  void fill_holes();

  std::vector<Cell> cells_;
  std::vector<std::uint8_t> own_marks_;  // by RingGrid::index(), of the beam alone
  std::vector<std::uint8_t> marks_;      // of the beam and its neighbours in the ring
  float width_ = 1;                      // of a column, in cells
  std::vector<Wedge> free_;              // the free pieces,
  std::vector<Wedge> blinds_;            // what no beam of a column sees,
  std::vector<Wedge> overs_;             // and ways over objects that are likely lower than the plane
  std::vector<Wedge> things_;            // where free pieces end at objects, while the vehicle drove
  std::vector<float> x_, y_, azimuths_;  // of the wedges; cells from -pi
  std::vector<float> begins_;            // azimuths of the wedges' first beams, for a tilted plane
  std::size_t rings_ = 0;
  const BeamEnd* ends_ = nullptr;
  std::array<float, 6> axes_{};  // of the frame's x and y in the cloud's frame
  Piece blind_{};                // of the next wedge
  float farthest_ = 0;           // m, nearest object in the band, of the current column
  float looked_from_ = 0;        // m, whole_band_from() of the current column
  const PlaneView* view_ = nullptr;
  const PlaneTops* tops_ = nullptr;
  float sensor_ = 0;  // m, distance from the plane
  float sign_ = 1;
  float corner_ = 0;  // share of the range by which an object may extend towards the sensor beside its return
  std::ptrdiff_t step_ = 1;       // from a beam to the next one away from the sensor's foot
  std::size_t nearest_ring_ = 0;  // to the sensor's foot
  HeightBand band_;
  float per_rad_ = 1;  // cells
  bool tilted_ = false;
};

}  // namespace lidard
