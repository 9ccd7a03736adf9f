// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/evidence/placed_scan.h"

namespace lidard {

/// Sets `sweep.linked`: which neighbouring returns belong to one surface.
///
/// The adaptive breakpoint rule: two returns are one surface if it need not be steeper than 10 degrees
/// against the beam (9 here, to leave room at the limit). A wall seen at a more grazing angle is recognised
/// by four returns on one line. A steep link between two surfaces that both go on is none: between coarse
/// beams the rule alone would bridge steps of more than a metre.
void link_neighbours(const BeamRays& rays, double noise, PlacedScan& sweep);

/// Marks veil points `doubtful` and unlinks them: returns between a near and a far surface that come from a
/// beam that touched both. Returns of a wall along the beam are exempt.
void mark_veils(const BeamRays& rays, double noise, PlacedScan& sweep);

/// Finds corners: two linked returns, with further ones on either side, whose surfaces meet between them.
/// Without the corner the straight line between both returns would cut it off. Needs the places.
void find_corners(double noise, PlacedScan& sweep);

}  // namespace lidard
