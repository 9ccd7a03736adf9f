// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/evidence/raster.h"
#include "core/virtual/ring_links.h"

namespace lidard {

/// An organised cloud relative to a plane z = const of a virtual frame: on which side of the plane and how
/// high above it every beam ends.
class PlaneView {
 public:
  /// Bits of sides(). `no_return`: the beam has no return.
  enum Side : std::uint8_t { no_return = 0, below = 1, above_it = 2, both_sides = 3, on_ground = 4 };
  /// cosine; upright surfaces are not extended to a plane that is less level than this.
  static constexpr float steepest = 0.3F;

  /// Sets the cloud; grid, ground and links must stay alive. `up` is the vertical in the cloud's frame.
  void set_cloud(const RingGrid& grid, const Ground& ground, const RingLinks& links,
                 const Eigen::Vector3f& up);
  /// Sets the virtual frame. Frames with the same directions of axes share what does not depend on their
  /// position.
  void set_frame(const Pose& virtual_from_cloud);
  /// Sets the plane z = `level`.
  void set_level(float level);

  const RingGrid& grid() const { return *grid_; }
  const Ground& ground() const { return *ground_; }
  const RingLinks& links() const { return *neighbours_; }
  const Eigen::Matrix3f& rotation() const { return rotation_; }

  /// m of z in the frame per m upward.
  float rise() const { return rise_; }
  /// m, height of a beam's end in the frame, by RingGrid::index(); valid only for beams with an end.
  const std::vector<float>& heights() const { return heights_; }
  /// m from the sensor to a beam's end along the frame's xy plane, by RingGrid::index().
  const std::vector<float>& reaches() const { return reaches_; }
  /// The same of one column from a point of the frame.
  void measure_reaches(std::size_t column, const Raster::Point& from, float* reaches) const;
  /// By RingGrid::index(); the first column is repeated after the last one.
  const std::vector<std::uint8_t>& sides() const { return sides_; }
  /// m above the plane, of a beam's end, of a point of the cloud's frame and of the sensor.
  float above(std::size_t i) const { return heights_[i] - level_; }
  float above(const BeamEnd& at) const {
    const auto& r = rotation_;
    return r(2, 0) * at.x + r(2, 1) * at.y + r(2, 2) * at.z + translation_.z() - level_;
  }
  float sensor_above() const { return translation_.z() - level_; }
  float level() const { return level_; }
  /// m from the sensor, level.
  float distance(std::size_t i) const { return ground_->distance[i]; }
  /// True if a surface may lie between two returns.
  bool is_surface(std::size_t a, std::size_t b) const { return ((sides_[a] | sides_[b]) & on_ground) == 0; }
  static bool are_opposite(std::uint8_t a, std::uint8_t b) { return ((a | b) & both_sides) == both_sides; }

  /// Points in the frame: a beam's end, the crossing of the plane with the line between two ends on either
  /// side, and the point of the plane straight beneath or above an end.
  Raster::Point project(const BeamEnd& end) const {
    const auto& r = rotation_;
    return {r(0, 0) * end.x + r(0, 1) * end.y + r(0, 2) * end.z + translation_.x(),
            r(1, 0) * end.x + r(1, 1) * end.y + r(1, 2) * end.z + translation_.y(), end.intensity};
  }
  Raster::Point between(std::size_t a, std::size_t b) const;
  Raster::Point straight_from(std::size_t i) const;

 private:
  void turn(const Eigen::Matrix3f& rotation);

  const RingGrid* grid_ = nullptr;
  const Ground* ground_ = nullptr;
  const RingLinks* neighbours_ = nullptr;
  Eigen::Vector3f up_ = Eigen::Vector3f::UnitZ();
  Eigen::Matrix3f rotation_ = Eigen::Matrix3f::Identity();
  Eigen::Vector3f translation_ = Eigen::Vector3f::Zero();
  float level_ = 0;
  float rise_ = 1;
  bool is_turned_ = false;              // rises_ and reaches_ are those of the cloud and rotation_
  std::vector<float> rises_, reaches_;  // m, of a beam's end above the sensor and level from it
  std::vector<float> heights_;
  std::vector<std::uint8_t> sides_;
};

/// A point on the line between two beams' ends.
inline BeamEnd mixed(const BeamEnd& a, const BeamEnd& b, float share) {
  return {a.x + share * (b.x - a.x), a.y + share * (b.y - a.y), a.z + share * (b.z - a.z),
          a.intensity + share * (b.intensity - a.intensity)};
}

/// Estimates how high an object reaches where the lower of two neighbouring rings hits it and the upper one
/// passes over it, and whether the object reaches the plane.
///
///    S (sensor)                 With level distances d and heights h above the plane, the upper beam passes
///     \ `-._                    over what the lower one hits at
///      \    `-._ passing            passing = h_S + (h_up - h_S) d_low / d_up.
///    ===\=======`-._======      The plane (===), at h = 0, lies at -top above the highest return (top); the
///        x top      `-._        object reaches it if
///    ____|______________`x_         -top < (passing - top) / 3.
///
/// The top of an object is at least as high as its highest return and lower than the lowest beam that passes
/// over it. Both limits come from all neighbouring columns that see the object, since tops are mostly level.
/// If the plane is close to the return, the object reaches it; if the plane is close to the beam, the object
/// likely does not. Of a face square to the beams, which looks like a top, nothing is known.
/// The object does not reach the plane if the returns lie on its level top or the beam is beneath the plane.
class PlaneTops {
 public:
  /// Result for a beam and the one below it. `hides`: the object that the upper beam hits may extend down to
  /// the plane behind the object that the lower beam hits. `top_alone`: the lowest ring meets a level top
  /// above the plane, or what may be one; nothing shows the front of the object.
  enum Verdict : std::uint8_t {
    none = 0,
    reaches = 1,
    stays_below = 2,
    hides = 3,
    likely_below = 4,
    top_alone = 5
  };

  void find(const PlaneView& view);
  /// By RingGrid::index() of the upper beam.
  const std::vector<std::uint8_t>& verdicts() const { return verdicts_; }

 private:
  /// Neighbouring columns in which a ring hits one object.
  struct Run {
    std::size_t first = 0, end = 0;  // columns [first, end)
    float top = 0;                   // m above the plane, the highest return
    float passing = 0;               // m above the plane, the lowest beam that passes over it and stays above
    float nearest = 0;               // m from the sensor
  };
  /// What most returns of a run lie on. A ring meets a level top at one distance, or meets the face beneath
  /// it while the next ring meets the top. The distance of a face square to the beams grows by half the
  /// distance times the square of the azimuth, and the ring beneath meets the face there, too. Noise may
  /// conceal which of the two a run is.
  enum class Shape : std::uint8_t { uneven, top, face, top_or_face };
  void mark_steps(const PlaneView& view);
  static float passing_over(const PlaneView& view, std::size_t upper);
  void add_step(const PlaneView& view, std::size_t column, std::size_t upper);
  void judge(const PlaneView& view, std::size_t ring, const Run& run);
  Shape shape_of(const PlaneView& view, std::size_t ring, const Run& run) const;

  std::vector<std::uint8_t> verdicts_;
  enum Step : std::uint8_t { no_step, step, over_face };
  std::vector<std::uint8_t> steps_;     // if the upper beam passes over the object that the lower one hits
  std::vector<std::vector<Run>> runs_;  // per upper ring
};

}  // namespace lidard
