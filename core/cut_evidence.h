// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "core/free_profile.h"
#include "core/plane_cut.h"

namespace lidard {

/// What the beams of an organised cloud prove of a plane of a virtual frame.
///
/// A beam proves the plane free only where it crosses it before its return. Two neighbouring beams of a
/// column that both cross it bound a piece of the plane that is taken to be free; so do a beam that crosses
/// it and the next one up to where that one meets something. Nearer than the nearest crossing no beam can
/// see: blind.
class CutEvidence {
 public:
  /// Free pieces that are kept of each direction: the nearest one, and one beyond something.
  static constexpr std::size_t pieces = 2;

  /// Finds the evidence for z = `level` of the frame that `cut` is set to. Free pieces end where something
  /// stands between the heights of `band` (of all returns but those from the ground). The profiles must have
  /// been set to the sensor's place; they are filled.
  void find(const RingGrid& grid, const Ground& ground, const PlaneCut& cut, float level, HeightBand band,
            const std::array<FreeProfile*, pieces>& free, FreeProfile& blind);

 private:
  struct Piece {
    float from = 0, to = -1;
    bool exists() const { return to >= from; }
  };
  struct Cell {
    std::array<Piece, pieces> free{};
    float blind = 0;
  };
  /// A beam as the plane sees it.
  struct Ray {
    float at = 0;        ///< m, level in the plane, where it crosses or would
    float end = 0;       ///< m, level in the plane, where it ends
    float x = 0, y = 0;  ///< towards its end
  };
  /// m above the plane, on the sensor's side of it.
  float above(std::size_t i) const { return sign_ * (cut_->heights()[i] - level_); }
  Ray ray(std::size_t i) const;
  void take_column(std::size_t column);
  void take_blind(const Ray& lowest);
  float azimuth(const Ray& ray) const;  // in cells
  /// The piece between two neighbouring beams, from where `a` crosses to `end`, seen along `b`.
  void take_wedge(const Ray& a, const Ray& b, float end);
  float wall_in_band(std::size_t column) const;
  void claim(float azimuth, float from, float to);
  void fill_holes();

  std::vector<Cell> cells_;
  float width_ = 1;     // of a column, in cells
  float farthest_ = 0;  // m, where something stands in the column at hand
  const RingGrid* grid_ = nullptr;
  const Ground* ground_ = nullptr;
  const PlaneCut* cut_ = nullptr;
  float level_ = 0;
  float sensor_ = 0;  // m above the plane, turned
  float sign_ = 1;
  HeightBand band_;
  float per_rad_ = 1;  // cells
  bool tilted_ = false;
};

}  // namespace lidard
