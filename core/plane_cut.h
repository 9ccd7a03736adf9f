// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/ground.h"
#include "core/height_band.h"
#include "core/raster.h"
#include "core/ring_links.h"

namespace lidard {

/// Cuts the surfaces of an organised cloud with planes z = const of a virtual frame and draws what it finds
/// into the beams of a virtual scan.
///
/// Four neighbouring returns (two rings, two columns) span two triangles, if they lie on one surface. Where
/// the ground is known, what stands on it reaches down to it: the edge between a return from the ground and
/// the return above it is no surface, and the latter's surface ends on the ground, unless a beam passed
/// beneath it. Edges between two returns from the ground are never drawn, unless `keep_ground`.
class PlaneCut {
 public:
  /// The cloud of all following cuts; the grid and the ground must stay alive. `up` is the vertical in the
  /// cloud's frame.
  void set_cloud(const RingGrid& grid, const Ground& ground, const RingLinks& links,
                 const Eigen::Vector3f& up);
  /// The frame of the following cuts.
  void set_frame(const Pose& virtual_from_cloud, bool keep_ground);

  /// Draws the cut with z = `level`; `marks`: beams in which a surface ends.
  void draw_slice(float level, const Raster& raster, RangeLayer& layer, std::vector<char>& marks);
  /// Draws all surfaces between two heights.
  void draw_band(HeightBand band, const Raster& raster, RangeLayer& layer, std::vector<char>& marks);

  /// Height of each beam's end in the virtual frame, by RingGrid::index(); only where it has one.
  const std::vector<float>& heights() const { return height_; }
  const Eigen::Matrix3f& rotation() const { return rotation_; }
  const Eigen::Vector3f& translation() const { return translation_; }

 private:
  /// In the virtual frame; `beam` is its azimuth in beams of the virtual scan.
  struct Place {
    Raster::Point point;
    float beam;
  };
  /// Where the plane crosses the surface between ring r and ring r + 1 of a column.
  struct Crossing {
    Place at{};
    Place neighbour{};  // at the other end of the newest segment
    bool exists = false;
    bool foot = false;  // of the upper return, on the ground
    int segments = 0;
  };
  /// What is between two returns of neighbouring rings that may belong together. `top`: the upper one lies on
  /// top of what the lower one is the face of. `nothing`: each is a face of its own.
  enum class Between : std::uint8_t { slope, top, nothing };
  using Column = std::vector<Crossing>;  // by the upper one of two rings
  struct Target {
    const Raster& raster;
    RangeLayer& layer;
    std::vector<char>& marks;
  };

  void set_level(float level);
  float above(std::size_t i) const { return height_[i] - level_; }
  bool is_surface(std::size_t a, std::size_t b) const;
  bool has_foot(std::size_t upper, std::size_t upper_ring) const;
  bool passes_beneath(std::size_t lower, std::size_t upper) const;
  float distance(std::size_t i) const;
  Place place(float x, float y, float z, float intensity, const Raster& raster) const;
  Place between(std::size_t a, std::size_t b, const Raster& raster) const;
  Place straight_from(std::size_t i, const Raster& raster) const;
  Between between_rings(std::size_t column, std::size_t upper) const;
  void cross_column(std::size_t column, const Raster& raster, Column& crossings) const;
  bool cross_level(std::size_t column, std::size_t ring, const Raster& raster, Place& at) const;
  void connect(std::size_t column, Column& here, Column& next, const Target& target) const;
  void join(Crossing* a, const Place& at_a, Crossing* b, const Place& at_b, const Target& target) const;
  void flush(const Column& crossings, const Target& target) const;
  void draw_edges(HeightBand band, const Target& target) const;
  void draw_clipped(std::size_t a, std::size_t b, HeightBand band, const Target& target) const;

  const RingGrid* grid_ = nullptr;
  const Ground* ground_ = nullptr;
  const RingLinks* links_ = nullptr;
  Eigen::Vector3f up_ = Eigen::Vector3f::UnitZ();
  Eigen::Matrix3f rotation_ = Eigen::Matrix3f::Identity();
  Eigen::Vector3f translation_ = Eigen::Vector3f::Zero();
  bool keep_ground_ = false;
  float level_ = 0;
  float rise_ = 1;             // m of height in the virtual frame per m upward
  std::vector<float> height_;  // m
  std::vector<char> side_;     // of the plane, by index(); see Side
  Column first_, here_, next_;
};

}  // namespace lidard
