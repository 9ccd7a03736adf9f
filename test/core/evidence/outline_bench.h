// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/base/angle.h"
#include "core/evidence/visibility.h"

namespace lidard::test::outline {

/// Of a ray, m from its begin.
struct Piece {
  double from, to;
};

/// The pieces of a ray inside the outlines of one source, edge by edge; shares nothing with Crossings.
inline std::vector<Piece> free_pieces(const Outlines& outlines, std::size_t source, const Eigen::Vector2d& at,
                                      double angle) {
  const Eigen::Vector2d ray(std::cos(angle), std::sin(angle));
  const auto vertex = [&](std::uint32_t i) -> Eigen::Vector2d {
    return Eigen::Vector2d(static_cast<double>(outlines.x[i]), static_cast<double>(outlines.y[i])) - at;
  };
  std::vector<std::pair<double, int>> crossings;  // m, and the change of layers outward
  int layers = 0;
  for (const Outlines::Edge& edge : outlines.edges) {
    if (edge.source != source || edge.free == 0) continue;
    const Eigen::Vector2d p = vertex(edge.from), q = vertex(edge.to);
    const double a = ray.x() * p.y() - ray.y() * p.x(), b = ray.x() * q.y() - ray.y() * q.x();
    if ((a > 0) == (b > 0)) continue;
    const double distance = (p + a / (a - b) * (q - p)).dot(ray);
    if (distance < 0) continue;
    const int change = a < b ? edge.free : -edge.free;
    crossings.emplace_back(distance, change);
    layers -= change;
  }
  std::sort(crossings.begin(), crossings.end());
  std::vector<Piece> pieces;
  double from = 0;
  for (const auto& [distance, change] : crossings) {
    const bool was_free = layers > 0;
    layers += change;
    if (!was_free && layers > 0) from = distance;
    if (!was_free || layers > 0) continue;
    // Pieces that touch are one.
    if (!pieces.empty() && from - pieces.back().to < 1e-4)
      pieces.back().to = distance;
    else if (distance - from > 1e-4)
      pieces.push_back({from, distance});
  }
  return pieces;
}

/// Adds the free space of a source whose beams divide the full circle evenly, counter-clockwise from the
/// first axis's negative end.
inline void add_ring(Visibility& visibility, const Eigen::Vector2d& at, const std::vector<Piece>& pieces,
                     std::size_t source = 0) {
  const double step = two_pi / static_cast<double>(pieces.size());
  std::vector<Outlines::Beam> beams(pieces.size() + 1);
  for (std::size_t i = 0; i < beams.size(); ++i) {
    const Piece& piece = pieces[i % pieces.size()];
    const double angle = static_cast<double>(i % pieces.size()) * step - pi_d;
    const Eigen::Vector2f ray(static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle)));
    const Eigen::Vector2f origin = at.cast<float>();
    const Eigen::Vector2f end = origin + static_cast<float>(piece.to) * ray,
                          begin = origin + static_cast<float>(piece.from) * ray;
    Outlines::Beam& beam = beams[i];
    beam.ox = origin.x(), beam.oy = origin.y(), beam.ux = ray.x(), beam.uy = ray.y();
    beam.x = end.x(), beam.y = end.y(), beam.bx = begin.x(), beam.by = begin.y();
    beam.length = static_cast<float>(piece.to), beam.from = static_cast<float>(piece.from);
    beam.to_next = piece.to == pieces[(i + 1) % pieces.size()].to;
  }
  visibility.outlines(source, Visibility::seen, step, at.norm())
      .add_strip(beams, static_cast<float>(step), Outlines::Side::joined, Outlines::Side::joined);
}

}  // namespace lidard::test::outline
