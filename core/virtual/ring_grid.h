// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/evidence/beam_rays.h"
#include "core/frames/cloud.h"
#include "core/motion/frame_motion.h"

namespace lidard {

/// Directions of the beams of a multi-plane lidar, for beams without return: those of the cloud, as long as
/// its returns do not show others.
class RingTable {
 public:
  /// Resets the table when the number of rings changes.
  void set_rings(const Cloud& cloud);
  /// Learns from a part of a cloud's returns (from all of the first cloud). `with_offsets`: the columns have
  /// azimuths, counted clockwise.
  void learn(const Cloud& cloud, bool with_offsets);

  bool is_known(std::size_t ring) const { return rings_[ring].count > 0; }
  /// rad above the sensor's x-y plane.
  double elevation(std::size_t ring) const { return rings_[ring].mean(rings_[ring].elevations); }
  /// rad by which the ring's beam is ahead of its column's azimuth.
  double offset(std::size_t ring) const { return rings_[ring].mean(rings_[ring].offsets); }

 private:
  struct Ring {
    double elevations = 0, offsets = 0;  // sums
    double count = 0;
    double mean(double sum) const { return count > 0 ? sum / count : 0; }
  };
  void add(const Cloud& cloud, std::size_t begin, std::size_t end, const CloudColumn* column);
  void fade();

  std::vector<Ring> rings_;
  std::size_t clouds_ = 0;
};

/// Finds the rings of a cloud without ring numbers: one elevation (rad) per ring, ascending. Empty if the
/// returns' elevations do not form groups.
void find_rings(const Cloud& cloud, std::vector<float>& elevations);

/// State of a beam of a cloud. `unknown`: it was not fired or its packet was lost. `none`: no return. `own`:
/// the return is too near to measure or hit the vehicle; nothing is known beyond.
enum class Beam : std::uint8_t { unknown, none, point, own };

/// Where a beam ends, m in the cloud's frame.
struct alignas(16) BeamEnd {
  float x, y, z;
  float intensity;
};

/// How a cloud is organised.
struct RingGridSettings {
  /// Free range that a beam without return proves, m; 0: none.
  double no_return_free_range = 0;
  /// Keeps earlier returns of a firing as single points; the last one is surface.
  bool early_returns = false;
};

/// A cloud as a grid of rings (from the lowest beam on the vehicle to the highest) and azimuth columns.
/// Neighbours of a beam are the same ring in the next column and the next ring in the same column.
///
/// Lasers with different azimuth offsets are sorted into columns: the beams of one column point to one
/// azimuth within half a column. Columns of lost packets stay `unknown`. Buffers keep their memory.
class RingGrid {
 public:
  explicit RingGrid(const RingGridSettings& settings) : settings_(settings) {}

  /// Sets the vehicle's outline (with its margin) in the vehicle frame and the pose of clouds in that frame:
  /// returns inside hit the vehicle.
  void set_footprint(const Footprint& own, const Pose& vehicle_from_cloud);
  /// Sorts a cloud into the grid; false if its rings and columns cannot be determined (why_not()). `motion`
  /// moves the ends of beams; ring and column follow from the measured position.
  bool organise(const Cloud& cloud, const CloudMotion* motion = nullptr);
  const char* why_not() const { return why_not_; }
  /// True if the columns are firings of the sensor; false if returns were put into columns by their azimuths.
  bool fired_in_columns() const { return !by_azimuth_; }

  std::size_t rings() const { return rings_; }
  std::size_t columns() const { return columns_; }
  /// The next column; the columns make a full turn, or more (see lead()).
  std::size_t after(std::size_t column) const { return column + 1 < columns_ ? column + 1 : 0; }
  /// rad between columns.
  double step() const { return step_; }
  /// rad, of a ring above the sensor's x-y plane.
  double elevation(std::size_t ring) const { return elevations_[ring]; }
  /// False while the ring has had no return.
  bool is_known(std::size_t ring) const { return known_[ring] != 0; }
  std::size_t index(std::size_t column, std::size_t ring) const { return column * rings_ + ring; }
  bool has_column(std::size_t column) const { return fired_[column] != 0; }

  /// By index(): the return, or the end of the free range of a beam without return.
  std::vector<BeamEnd> ends;
  std::vector<float> range;  ///< m from the sensor
  std::vector<Beam> kind;
  std::vector<BeamEnd> early;     ///< earlier returns of firings
  bool moved = false;             ///< the vehicle drove while the cloud was measured
  std::vector<BeamEnd> origins;   ///< where it was at each column, if it drove
  std::uint64_t own_returns = 0;  ///< returns from the vehicle, since the start
  std::uint64_t outside = 0;      ///< points without a cell in the grid, since the start

 private:
  bool fires_in_columns(const Cloud& cloud);
  void organise_columns(const Cloud& cloud, const CloudMotion* motion);
  void number_columns(const Cloud& cloud, std::size_t lead);
  std::size_t lead(const Cloud& cloud, const CloudMotion& motion) const;
  void fill_lead(std::size_t lead, const CloudMotion& motion);
  void keep_tail(const Cloud& cloud);
  void number_shifts();
  void open_column(std::size_t column, double azimuth);
  bool goes_round(std::size_t column, std::size_t row) const;
  void extend_azimuths();
  void fill_column(const Cloud& cloud, std::size_t column, std::size_t to_column, const Pose* move);
  void find_origins(const CloudMotion& motion);
  void measure_ranges();
  void check(std::size_t at);
  void mark_too_near(const NearReturn& near, std::size_t to_column);
  bool organise_points(const Cloud& cloud, const CloudMotion* motion);
  bool number_rings(const Cloud& cloud);
  bool measure_step(const Cloud& cloud);
  void measure_phases(const Cloud& cloud);
  void fill_points(const Cloud& cloud, const CloudMotion* motion);
  void open_gaps();
  void clear_grid(std::size_t columns, std::size_t rings);
  void put(std::size_t at, const CloudPoint& point, const Pose* move);
  bool is_own(const BeamEnd& end) const;
  /// Of a lidar that hangs upside down the last ring is the lowest.
  std::size_t row_of(std::size_t ring) const { return hangs_ ? rings_ - 1 - ring : ring; }
  void fill_without_return(const Cloud& cloud, const CloudMotion* motion);
  void bridge_single_gaps();
  void bridge(std::size_t before, std::size_t at, std::size_t after);

  RingGridSettings settings_;
  RingTable table_;
  Footprint own_;
  Pose vehicle_from_cloud_ = Pose::Identity();
  float own_reach_ = 0;  // m from the cloud's origin to the vehicle's farthest corner
  bool hangs_ = false;   // upside down
  const char* why_not_ = "";
  std::size_t rings_ = 0;
  std::size_t columns_ = 0;
  bool by_azimuth_ = false;  // the cloud has no firing columns
  double step_ = 0;
  std::vector<double> elevations_;
  std::vector<char> known_;
  std::vector<float> level_, rise_;  // m, end of a beam without return, per ring
  std::vector<char> fired_;
  std::vector<float> azimuths_;               // rad per column, counted clockwise
  std::vector<float> times_;                  // s after the cloud's stamp, per column
  std::vector<double> turns_;                 // rad from the previous column, per column of the cloud
  std::vector<std::uint32_t> to_columns_;     // column in the grid, per column of the cloud
  std::size_t lead_ = 0;                      // columns of the cloud before, at the begin
  Cloud tail_;                                // the last columns of the cloud before
  std::vector<std::size_t> tail_to_columns_;  // their columns in the grid
  std::vector<std::uint32_t> shifts_;         // columns by which a row points ahead, in [0, columns_)
  std::vector<std::size_t> offsets_;          // index of a ring's beam relative to the begin of its column
  bool straight_ = false;                     // all rings are known and not shifted
  std::vector<std::uint16_t> rows_;           // row per ring number of the cloud, for clouds without columns
  std::vector<float> found_;                  // elevations of the rings, for clouds without ring numbers
  std::vector<float> point_azimuths_;         // rad per point, clockwise from behind, >= 0
  std::vector<std::uint16_t> point_rows_;     // per point; 0xFFFF: none
  std::size_t measured_rings_ = 0;            // number of rings when step_ was measured
  std::size_t clouds_ = 0;                    // sorted by azimuth
  std::vector<float> phases_, phase_sines_;   // per ring: position of its beams within a column's width
  std::vector<std::vector<float>> steps_;     // rad between returns, per ring
};

}  // namespace lidard
