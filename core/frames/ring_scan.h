// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/frames/cloud.h"
#include "core/frames/scan.h"

namespace lidard {

/// One ring of a multi-plane lidar as a planar scan.
struct RingScanSpec {
  std::uint16_t ring = 0;          ///< 0 = lowest
  double resolution = 0.00349066;  ///< rad between beams; rounded so that a turn has a whole number of them
  double range_min = 0;            ///< m
  double range_max = 0;            ///< m
};

/// Makes the planar scan of one ring, revolution by revolution.
///
/// Beams follow each other as the lidar turns: Velodynes turn clockwise, so angle_increment is negative and
/// time_increment positive; beam 0 stands where the revolution begins and is the first ray. Ranges are those
/// in the sensor's x-y plane. Between two firings that met the same surface (its grazing angle is above 18
/// deg) a beam's range is where it crosses the line between their returns; elsewhere that of the firing
/// nearest in angle. A nearer return inside a beam's width that is no part of that surface wins, so that no
/// thin thing is lost to a coarse resolution, and so does the nearer one of two echoes. A firing without a
/// return is `none`, one with a return nearer than the driver's min_range `near`; where nothing was fired
/// beams are `invalid`. No allocation once the largest revolution was seen.
class RingScan {
 public:
  explicit RingScan(const RingScanSpec& spec);

  /// The limits of ranges, m, of what is converted from now on.
  void set_ranges(double range_min, double range_max);
  /// False if the revolution is too short to measure the speed of rotation; `scan` is invalid then. The first
  /// revolution converted fixes the angles.
  bool convert(const Cloud& cloud, PlanarScan& scan);

 private:
  /// One firing of the ring; angles in rad as the lidar turns, from the scan's begin.
  struct Firing {
    double position;
    float range, intensity;
    BeamStatus status;
  };
  void gather(const Cloud& cloud);
  void merge_echo(const Firing& echo);
  bool measure(const Cloud& cloud);
  double mean_step(double limit) const;
  void find_positions(const Cloud& cloud);
  void fill(PlanarScan& scan) const;
  void set_beam(PlanarScan& scan, std::size_t beam, const Firing& a, const Firing& b) const;
  void keep_nearer(PlanarScan& scan, std::size_t beam, const Firing& firing) const;
  bool same_surface(const Firing& a, const Firing& b) const;
  void put(PlanarScan& scan, std::size_t beam, double range, float intensity) const;
  void put(PlanarScan& scan, std::size_t beam, const Firing& firing) const;

  RingScanSpec spec_;
  std::size_t beams_;
  double increment_;
  bool begin_known_ = false;
  double begin_ = 0;           // rad, as the sensor counts azimuth
  double offset_rad_ = 0;      // of the ring's beam against its column's azimuth
  Span offset_time_{0};        // of its firing after the column's stamp
  double first_position_ = 0;  // rad from the begin, of the first firing
  double rate_ = 0;            // rad/s
  double step_ = 0;            // rad between firings
  std::vector<Firing> firings_;
};

}  // namespace lidard
