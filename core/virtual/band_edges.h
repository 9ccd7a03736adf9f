// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/evidence/height_band.h"
#include "core/evidence/raster.h"
#include "core/virtual/plane_view.h"

namespace lidard {

/// Draws what an organised cloud shows between two heights of the view's frame: the lines between
/// neighbouring returns of one surface, as far as they are in the band, and single returns. What the band's
/// limits cut is left to PlaneCut.
void draw_band_edges(const PlaneView& view, HeightBand band, const Raster& raster, RangeLayer& layer);

}  // namespace lidard
