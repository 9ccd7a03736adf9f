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
  std::int32_t* const to = beams_.data();
  for (std::size_t i = 0; i < n; ++i) {
    // A vertex that is no number has the first beam's direction.
    const float position = at[i] >= 0 ? at[i] : 0;
    const auto below = static_cast<std::int32_t>(position);
    const std::int32_t up = below + (static_cast<float>(below) < position ? 1 : 0);
    to[i] = up < most ? up : most;
  }
}

void Crossings::find(const Outlines& outlines, const Raster& raster) {
  find_beams(outlines, raster);
  found_.clear();
  const auto beams = static_cast<std::int32_t>(raster.grid().beams);
  const float half = raster.turn() / 2;
  for (std::uint32_t e = 0; e < outlines.edges.size(); ++e) {
    const Outlines::Edge& edge = outlines.edges[e];
    const float span = positions_[edge.to] - positions_[edge.from];
    const std::int32_t from = beams_[edge.from], to = beams_[edge.to];
    if (std::fabs(span) <= half) {
      if (from < to) cross(outlines, e, from, to, false, raster);
      if (to < from) cross(outlines, e, to, from, true, raster);
    } else {
      // The shorter way leads over the begin of the turn.
      const bool clockwise = span > 0;
      cross(outlines, e, 0, clockwise ? from : to, clockwise, raster);
      cross(outlines, e, clockwise ? to : from, beams, clockwise, raster);
    }
  }
  sort(raster.grid().beams);
}

inline void Crossings::cross(const Outlines& outlines, std::uint32_t e, std::int32_t first, std::int32_t end,
                             bool clockwise, const Raster& raster) {
  const Outlines::Edge& edge = outlines.edges[e];
  const float px = outlines.x[edge.from], py = outlines.y[edge.from];
  const float qx = outlines.x[edge.to], qy = outlines.y[edge.to];
  for (auto beam = static_cast<std::uint32_t>(first); beam < static_cast<std::uint32_t>(end); ++beam) {
    const float c = raster.cosine(beam), s = raster.sine(beam);
    const float side_p = c * py - s * px, side_q = c * qy - s * qx;
    const float ahead_p = c * px + s * py, ahead_q = c * qx + s * qy;
    const float both = side_p - side_q;
    // If an edge lies along the beam, its nearer end counts.
    const float along = ahead_p < ahead_q ? 0.0F : 1.0F;
    const float share = std::fabs(both) < thinnest ? along : std::clamp(side_p / both, 0.0F, 1.0F);
    const float at = std::max(ahead_p + share * (ahead_q - ahead_p), 0.0F);
    found_.push_back({{at, e, clockwise}, beam});
  }
}

/// Sorts what was found by beam, and by distance within a beam.
void Crossings::sort(std::size_t beams) {
  firsts_.assign(beams + 2, 0);
  for (const Found& found : found_) ++firsts_[found.beam + 2];
  for (std::size_t beam = 2; beam < firsts_.size(); ++beam) firsts_[beam] += firsts_[beam - 1];
  resize_amply(found_.size(), sorted_);
  // firsts_[beam + 1] grows from the begin of a beam's crossings to their end.
  for (const Found& found : found_) {
    std::uint32_t& end = firsts_[found.beam + 1];
    sorted_[end++] = found.crossing;
  }
  for (std::size_t beam = 0; beam < beams; ++beam) {
    Crossing* const first = sorted_.data() + firsts_[beam];
    Crossing* const last = sorted_.data() + firsts_[beam + 1];
    constexpr std::ptrdiff_t few = 32;
    if (last - first > few) {
      std::sort(first, last, [](const Crossing& a, const Crossing& b) { return a.at < b.at; });
      continue;
    }
    // Mostly there are four to six; an insertion sort is the fastest.
    for (Crossing* next = first + 1; next < last; ++next) {
      const Crossing crossing = *next;
      Crossing* to = next;
      for (; to > first && crossing.at < to[-1].at; --to) *to = to[-1];
      *to = crossing;
    }
  }
}

}  // namespace lidard
