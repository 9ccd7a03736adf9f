// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtual/band_edges.h"

namespace lidard {
namespace {

/// The part of the line between two returns whose height is in the band.
void draw_clipped(const PlaneView& view, std::size_t a, std::size_t b, HeightBand band, const Raster& raster,
                  RangeLayer& layer) {
  const float za = view.heights()[a];
  const float zb = view.heights()[b];
  const auto low = static_cast<float>(band.min);
  const auto high = static_cast<float>(band.max);
  if ((za < low && zb < low) || (za > high && zb > high)) return;
  const auto share_at = [&](float z, float limit) { return z == limit ? 0.0F : (limit - za) / (zb - za); };
  const float from = za < low ? share_at(za, low) : za > high ? share_at(za, high) : 0.0F;
  const float to = zb < low ? share_at(zb, low) : zb > high ? share_at(zb, high) : 1.0F;
  const BeamEnd& begin = view.grid().ends[a];
  const BeamEnd& end = view.grid().ends[b];
  raster.draw_segment(view.place(mixed(begin, end, from)), view.place(mixed(begin, end, to)), layer);
}

}  // namespace

void draw_band_edges(const PlaneView& view, HeightBand band, const Raster& raster, RangeLayer& layer) {
  const RingGrid& grid = view.grid();
  const RingLinks& links = view.links();
  for (std::size_t c = 0; c < grid.columns(); ++c) {
    const std::size_t before = c > 0 ? c - 1 : grid.columns() - 1;
    for (std::size_t r = 0; r < grid.rings(); ++r) {
      const std::size_t i = grid.index(c, r);
      const bool on_ground = (view.sides()[i] & PlaneView::on_ground) != 0;
      if (grid.kind[i] != Beam::point || (on_ground && !view.keeps_ground())) continue;
      const std::size_t beside = grid.index(grid.after(c), r);
      const bool level = view.is_surface(i, beside) && links.level(c, r);
      const bool upright = r + 1 < grid.rings() && view.is_surface(i, i + 1) && links.upright(c, r);
      if (level) draw_clipped(view, i, beside, band, raster, layer);
      if (upright) draw_clipped(view, i, i + 1, band, raster, layer);
      const auto height = static_cast<double>(view.heights()[i]);
      if (level || upright || height < band.min || height > band.max) continue;
      if (links.level(before, r) || (r > 0 && links.upright(c, r - 1))) continue;
      raster.draw_point(view.place(grid.ends[i]), layer);
    }
  }
}

}  // namespace lidard
