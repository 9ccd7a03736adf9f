// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "core/evidence/footprint.h"
#include "core/evidence/height_band.h"
#include "core/frames/scan.h"

namespace lidard {

/// The beams of one scanner seen from an output frame: constant while mount and beams stay the same, so that
/// everything that costs trigonometry is done once.
class BeamRays {
 public:
  /// True if these rays already belong to that scanner in that place.
  bool fits(const PlanarScan& scan, const Pose& output_from_sensor) const;
  /// Builds them; `footprint` is the vehicle's outline, `band` the heights that count, in the output frame.
  void build(const PlanarScan& scan, const Pose& output_from_sensor, const Footprint& footprint,
             HeightBand band);

  std::size_t size() const { return x.size(); }

  Pose pose = Pose::Identity();  ///< output_from_sensor
  double angle_min = 0;          ///< rad, sensor frame
  double increment = 0;          ///< rad
  std::vector<float> x, y, z;    ///< direction in the output frame, per m of range
  std::vector<float> level;      ///< m in the output's plane per m of range
  std::vector<float> cosine;     ///< in the sensor frame
  std::vector<float> sine;
  std::vector<float> own_begin;  ///< ranges in [own_begin, own_end] are the vehicle itself; inf: none
  std::vector<float> own_end;
  std::vector<float> blocked_at;  ///< range where the beam runs into the body from outside; inf: nowhere
  std::vector<float> band_begin;  ///< ranges in [band_begin, band_end] are at heights that count
  std::vector<float> band_end;    ///< below band_begin: none of them
  std::vector<char> from_inside;  ///< the beam begins inside and stays so for more than a housing's depth

 private:
  void add_beam(double angle, const Footprint& body, const Footprint& margin, HeightBand band);
};

}  // namespace lidard
