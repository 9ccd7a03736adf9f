// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "core/base/time.h"
#include "core/frames/scan.h"
#include "drivers/sick/cola/cola_models.h"
#include "drivers/sick/cola/cola_scan.h"

namespace lidard::sick {

/// Where and when the beams of a telegram were measured.
struct ColaGeometry {
  std::size_t beams = 0;
  std::size_t echoes = 0;
  double start_deg = 0, step_deg = 0;  ///< as the device counts
  double scan_hz = 0;
  double beam_period = 0;  ///< s

  /// rad in the device's ROS frame; fractions of a beam are allowed.
  double angle(const ColaRow& row, double beam) const;
  Span sweep() const;
  friend bool operator==(const ColaGeometry& a, const ColaGeometry& b);
};

/// False if the telegram has no distances, or its channels contradict each other.
bool read_geometry(const ColaScan& scan, const ColaRow& row, ColaGeometry& geometry);
/// "811 beams from -45.0000 deg in steps of 0.33333 deg, 15.00 Hz".
std::string describe(const ColaGeometry& geometry);

/// A step that the telegram holds in 1/10000 deg: 0.3333 stands for 1/3, 0.1667 for 1/6.
double exact_step_deg(double told);

/// What a raw distance means. Values below 16 are codes (sick_scan_xd, README of the data formats): 0 no
/// echo, 1 dazzled, others unknown. That 0 always means free space is unverified.
BeamStatus status_of_raw(std::uint16_t raw);
constexpr std::uint16_t first_distance = 16;

}  // namespace lidard::sick
