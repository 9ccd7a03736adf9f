// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/evidence/raster.h"
#include "core/virtual/ground.h"
#include "core/virtual/ring_links.h"

namespace lidard {

/// An organised cloud as a plane z = const of a virtual frame sees it: on which side of the plane each beam
/// ends, and how high above it.
class PlaneView {
 public:
  /// Bits of side(). `no_return`: the beam has none.
  enum Side : std::uint8_t { no_return = 0, below = 1, above_it = 2, both_sides = 3, on_ground = 4 };
  /// A virtual frame's plane less level than that (cosine) is not crossed by what stands upright.
  static constexpr float steepest = 0.3F;

  /// The cloud of all following planes; grid, ground and links must stay alive. `up` is the vertical in the
  /// cloud's frame.
  void set_cloud(const RingGrid& grid, const Ground& ground, const RingLinks& links,
                 const Eigen::Vector3f& up);
  /// The frame of the following planes; `keep_ground`: the ground is a surface too.
  void set_frame(const Pose& virtual_from_cloud, bool keep_ground);
  /// The plane z = `level`.
  void set_level(float level);

  const RingGrid& grid() const { return *grid_; }
  const Ground& ground() const { return *ground_; }
  const RingLinks& links() const { return *links_; }
  const Eigen::Matrix3f& rotation() const { return rotation_; }
  const Eigen::Vector3f& translation() const { return translation_; }
  bool keeps_ground() const { return keep_ground_; }

  /// m per m upward.
  float rise() const { return rise_; }
  /// m, height of a beam's end in the frame, by RingGrid::index(); only where it has one.
  const std::vector<float>& heights() const { return heights_; }
  /// By RingGrid::index(), and the first column once more after the last.
  const std::vector<std::uint8_t>& sides() const { return sides_; }
  /// m above the plane, of a beam's end and of the sensor.
  float above(std::size_t i) const { return heights_[i] - level_; }
  float sensor_above() const { return translation_.z() - level_; }
  float level() const { return level_; }
  /// m from the sensor, level.
  float distance(std::size_t i) const { return ground_->distance[i]; }
  /// Two returns between which a surface may be.
  bool is_surface(std::size_t a, std::size_t b) const {
    const int grounds = (sides_[a] & on_ground) + (sides_[b] & on_ground);
    return grounds == 0 || (keep_ground_ && grounds == 2 * on_ground);
  }
  static bool are_opposite(std::uint8_t a, std::uint8_t b) { return ((a | b) & both_sides) == both_sides; }

  /// Places in the frame: of a beam's end, where the line between two ends on either side crosses the plane,
  /// and where the plane is straight beneath or above an end.
  Raster::Point place(const BeamEnd& end) const;
  Raster::Point between(std::size_t a, std::size_t b) const;
  Raster::Point straight_from(std::size_t i) const;

 private:
  const RingGrid* grid_ = nullptr;
  const Ground* ground_ = nullptr;
  const RingLinks* links_ = nullptr;
  Eigen::Vector3f up_ = Eigen::Vector3f::UnitZ();
  Eigen::Matrix3f rotation_ = Eigen::Matrix3f::Identity();
  Eigen::Vector3f translation_ = Eigen::Vector3f::Zero();
  bool keep_ground_ = false;
  float level_ = 0;
  float rise_ = 1;
  std::vector<float> heights_;
  std::vector<std::uint8_t> sides_;
};

/// A point of the line between two beams' ends.
inline BeamEnd mixed(const BeamEnd& a, const BeamEnd& b, float share) {
  return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), a.z + share * (b.z - a.z),
          a.intensity + share * (b.intensity - a.intensity)};
}

}  // namespace lidard
