// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/base/angle.h"
#include "core/evidence/placed_scan.h"

namespace lidard {

/// Limits of the adaptive breakpoint rule (Borges and Aldon, "Line extraction in 2D range images for mobile
/// robotics", 2004), for neighbouring beams of a scan and of a cloud alike.
namespace breakpoint {
constexpr double steepest = 9 * rad_per_deg;  // between surface and beam
constexpr float longest_grazing_step = 3;     // m
constexpr float steady_growth = 2.5F;         // of the steps along a wall
constexpr float line_tolerance = 0.005F;      // m, beside the noise
}  // namespace breakpoint

/// Sets `sweep.linked`: which neighbouring returns belong to one surface.
///
/// Two returns are one surface if it need not be steeper than 10 degrees against the beam (9 here, to leave
/// room at the limit): with ranges a <= b, s the angle between the beams, l = 9 degrees and sigma the noise
///     |P_a P_b| <= a sin(s) / sin(l - s) + 3 sigma.
/// A wall seen at a more grazing angle is recognised by four returns on one line. A steep link between two
/// surfaces that both go on is none: between coarse beams the rule alone would bridge steps of more than a
/// metre.
void link_neighbours(const BeamRays& rays, double noise, PlacedScan& sweep);

/// Marks veil points `doubtful` and unlinks them. A veil point is what is elsewhere called a mixed pixel or a
/// shadow point (ROS: laser_filters' ScanShadowsFilter): a beam that touches the edge of a near surface and
/// the far one behind it measures a range in between, where nothing is. Returns of a wall along the beam are
/// exempt.
void mark_veils(const BeamRays& rays, double noise, PlacedScan& sweep);

/// Finds corners: two linked returns, with further ones on either side, whose surfaces meet between them.
/// Without the corner the straight line between both returns would cut it off. Needs the places.
void find_corners(double noise, PlacedScan& sweep);

}  // namespace lidard
