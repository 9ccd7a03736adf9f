// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/evidence/crossings.h"

#include <algorithm>
#include <cmath>

#include "core/base/bytes.h"
#include "core/base/clones.h"

namespace lidard {
namespace {

// m; an edge that extends less across a beam lies along it.
constexpr float thinnest = 2e-4F;

}  // namespace

LIDARD_CLONES void Crossings::find_beams(const Outlines& outlines, const Raster& raster) {
  const std::size_t n = outlines.x.size();
  resize_amply(n, positions_, beams_);
  raster.positions(outlines.x.data(), outlines.y.data(), n, positions_.data());
  const auto most = static_cast<std::int32_t>(raster.grid().beams);
  const float* const at = positions_.data();
  std::uint32_t* const to = beams_.data();
  for (std::size_t i = 0; i < n; ++i) {
    // A vertex that is no number has the first beam's direction.
    const float position = at[i] >= 0 ? at[i] : 0;
    const auto below = static_cast<std::int32_t>(position);
    const std::int32_t up = below + (static_cast<float>(below) < position ? 1 : 0);
    to[i] = static_cast<std::uint32_t>(up < most ? up : most);
  }
}

/// Calls use(first beam, end, whether they cross the edge clockwise).
template <class Use>
void Crossings::each_stretch(const Outlines::Edge& edge, const Raster& raster, Use use) const {
  const std::uint32_t from = beams_[edge.from], to = beams_[edge.to];
  const float span = positions_[edge.to] - positions_[edge.from];
  if (std::fabs(span) <= raster.turn() / 2) {
    if (from < to) use(from, to, false);
    if (to < from) use(to, from, true);
    return;
  }
  // The shorter way leads over the begin of the turn.
  const auto beams = static_cast<std::uint32_t>(raster.grid().beams);
  const bool clockwise = span > 0;
  use(0, clockwise ? from : to, clockwise);
  use(clockwise ? to : from, beams, clockwise);
}

/// Counts the crossings of every beam, and makes room for them.
void Crossings::count(const Outlines& outlines, const Raster& raster) {
  const std::size_t beams = raster.grid().beams;
  // Per beam by how many more edges it crosses than the beam before.
  ends_.assign(beams + 2, 0);
  for (const Outlines::Edge& edge : outlines.edges) {
    if (edge.beyond) continue;
    each_stretch(edge, raster, [this](std::uint32_t first, std::uint32_t end, bool) {
      ++ends_[first + 1];
      --ends_[end + 1];
    });
  }
  std::uint32_t crossed = 0, all = 0;
  for (std::size_t beam = 0; beam <= beams; ++beam) {
    crossed += ends_[beam + 1];
    ends_[beam + 1] = all;
    all += crossed;
  }
  resize_amply(all, crossings_);
}

void Crossings::find(const Outlines& outlines, const Raster& raster, std::size_t sources) {
  sources_ = sources;
  at_origin_.assign(raster.grid().beams * sources, {});
  find_beams(outlines, raster);
  count(outlines, raster);
  for (std::uint32_t e = 0; e < outlines.edges.size(); ++e) {
    each_stretch(outlines.edges[e], raster, [&](std::uint32_t first, std::uint32_t end, bool clockwise) {
      cross(outlines, e, first, end, clockwise, raster);
    });
  }
  for (std::size_t beam = 0; beam < raster.grid().beams; ++beam)
    sort(crossings_.data() + ends_[beam], crossings_.data() + ends_[beam + 1]);
}

inline void Crossings::cross(const Outlines& outlines, std::uint32_t e, std::uint32_t first,
                             std::uint32_t end, bool clockwise, const Raster& raster) {
  const Outlines::Edge& edge = outlines.edges[e];
  const float px = outlines.x[edge.from], py = outlines.y[edge.from];
  const float qx = outlines.x[edge.to], qy = outlines.y[edge.to];
  const int sign = clockwise ? -1 : 1;
  Crossing crossing{0, e, edge.source, static_cast<std::int8_t>(sign * edge.free),
                    static_cast<std::int8_t>(sign * edge.hidden)};
  for (std::uint32_t beam = first; beam < end; ++beam) {
    Layers& layers = at_origin_[beam * sources_ + edge.source];
    layers.free = static_cast<std::int16_t>(layers.free - crossing.free);
    layers.hidden = static_cast<std::int16_t>(layers.hidden - crossing.hidden);
  }
  if (edge.beyond) return;
  for (std::uint32_t beam = first; beam < end; ++beam) {
    const float c = raster.cosine(beam), s = raster.sine(beam);
    const float side_p = c * py - s * px, side_q = c * qy - s * qx;
    const float ahead_p = c * px + s * py, ahead_q = c * qx + s * qy;
    const float both = side_p - side_q;
    // If an edge lies along the beam, its nearer end counts.
    const float along = ahead_p < ahead_q ? 0.0F : 1.0F;
    const float share = std::fabs(both) < thinnest ? along : std::clamp(side_p / both, 0.0F, 1.0F);
    crossing.at = std::max(0.0F, ahead_p + share * (ahead_q - ahead_p));
    crossings_[ends_[beam + 1]++] = crossing;
  }
}

/// Sorts the crossings of a beam by distance.
void Crossings::sort(Crossing* first, Crossing* last) {
  if (last - first < 2) return;
  constexpr std::ptrdiff_t few = 32;
  if (last - first > few) {
    std::sort(first, last, [](const Crossing& a, const Crossing& b) { return a.at < b.at; });
    return;
  }
  // Mostly there are four to six; an insertion sort is the fastest.
  for (Crossing* next = first + 1; next < last; ++next) {
    const Crossing crossing = *next;
    Crossing* to = next;
    for (; to > first && crossing.at < to[-1].at; --to) *to = to[-1];
    *to = crossing;
  }
}

}  // namespace lidard
