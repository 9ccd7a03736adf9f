// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/surfaces.h"

#include <algorithm>
#include <cmath>

#include "core/base/angle.h"

namespace lidard {
namespace {

using Eigen::Vector2d;

constexpr std::size_t fewest_beams = 8;
constexpr double shortest_m = 0.15;
constexpr double flattest = 0.17;  // mean cosine of the angle of incidence: 80 degrees
// The returns of a surface are no farther off its line than this beside their noise, m and standard
// deviations: a curve is none.
constexpr double roughest_m = 0.008, noisiest = 1.5;
const double steepest_jump = std::tan(82 * rad_per_deg);
constexpr std::size_t local_reach = 4;
// Two lasers see one upright face if their lines agree so well, m and rad.
constexpr double same_face_m = 0.02, same_face_rad = 2.5 * rad_per_deg, apart_m = 0.1;
constexpr std::size_t ring_reach = 3;

struct Line {
  Vector2d middle{0, 0}, along{1, 0}, normal{0, 1};
};

/// m^2 by which the noise of its range moves a return across a line.
double variance_across(const StillBeam& beam, const Vector2d& normal) {
  const double across = std::max(0.05, std::abs(normal.dot(beam.point)) / beam.range) * beam.sigma;
  return across * across;
}

/// The line through beams [first, last], each weighted by what its range noise moves across the line.
Line fit(const std::vector<StillBeam>& beams, std::size_t first, std::size_t last) {
  Line line;
  for (int round = 0; round < 3; ++round) {
    const auto weight = [&, normal = line.normal](std::size_t i) {
      return round == 0 ? 1 : 1 / variance_across(beams[i], normal);
    };
    double sum = 0;
    line.middle.setZero();
    for (std::size_t i = first; i <= last; ++i) sum += weight(i), line.middle += weight(i) * beams[i].point;
    line.middle /= sum;
    double xx = 0, xy = 0, yy = 0;
    for (std::size_t i = first; i <= last; ++i) {
      const Vector2d d = beams[i].point - line.middle;
      xx += weight(i) * d.x() * d.x(), xy += weight(i) * d.x() * d.y(), yy += weight(i) * d.y() * d.y();
    }
    const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
    line.along = {std::cos(angle), std::sin(angle)};
    line.normal = {-line.along.y(), line.along.x()};
    if (line.normal.dot(line.middle) > 0) line.normal = -line.normal, line.along = -line.along;
  }
  return line;
}

bool make_surface(const StillView& view, std::size_t first, std::size_t last, Surface& surface) {
  // Beams at the ends may have met an edge.
  if (last - first + 1 < fewest_beams + 2) return false;
  ++first, --last;
  const std::vector<StillBeam>& beams = view.beams;
  const Line line = fit(beams, first, last);
  surface.middle = line.middle, surface.along = line.along, surface.normal = line.normal;
  double sum = 0, across = 0, moment = 0, turning = 0, cosine = 0, rough = 0, noise = 0;
  const auto count = static_cast<double>(last - first + 1);
  surface.from = surface.to = surface.height = 0;
  for (std::size_t i = first; i <= last; ++i) {
    const double variance = variance_across(beams[i], line.normal), w = 1 / variance;
    const Vector2d d = beams[i].point - line.middle;
    const double s = line.along.dot(d), off = line.normal.dot(d);
    const double u = line.normal.dot(beams[i].point) / beams[i].range;
    rough += off * off, noise += variance;
    sum += w, across += w * u, moment += w * s * s, turning += w * s * u;
    cosine += std::abs(u) / count;
    surface.height += beams[i].height / count;
    surface.from = std::min(surface.from, s), surface.to = std::max(surface.to, s);
  }
  if (surface.length() < shortest_m || cosine < flattest) return false;
  if (rough > count * roughest_m * roughest_m + noisiest * noisiest * noise) return false;
  surface.var_offset = 1 / sum, surface.var_slope = 1 / moment;
  surface.offset_by_range = across / sum, surface.slope_by_range = turning / moment;
  surface.ring = view.ring, surface.first_beam = first, surface.last_beam = last;
  for (std::size_t k = 0; k < surface.points.size(); ++k)
    surface.points[k] = beams[first + k * (last - first) / (surface.points.size() - 1)].point;
  return true;
}

/// Cuts a run of neighbouring returns where it bends, and appends the straight pieces.
void split(const StillView& view, std::size_t first, std::size_t last, std::vector<Surface>& surfaces) {
  const std::vector<StillBeam>& beams = view.beams;
  if (last - first + 1 < fewest_beams) return;
  const Vector2d chord = (beams[last].point - beams[first].point).normalized();
  const Vector2d normal(-chord.y(), chord.x());
  double farthest = 0, sigma = 0;
  std::size_t corner = first;
  for (std::size_t i = first; i <= last; ++i) {
    sigma = std::max(sigma, beams[i].sigma);
    const double off = std::abs(normal.dot(beams[i].point - beams[first].point));
    if (off > farthest) farthest = off, corner = i;
  }
  if (farthest <= 3 * std::max(0.008, 4 * sigma)) {
    Surface surface;
    if (make_surface(view, first, last, surface)) surfaces.push_back(surface);
    return;
  }
  split(view, first, corner, surfaces);
  split(view, corner, last, surfaces);
}

double angle_between(const Vector2d& a, const Vector2d& b) {
  return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
}

}  // namespace

void find_surfaces(const StillView& view, std::vector<Surface>& surfaces) {
  const std::vector<StillBeam>& beams = view.beams;
  const auto follows = [&](std::size_t i) {
    const StillBeam &a = beams[i - 1], &b = beams[i];
    const double limit =
        std::max(6 * std::max(a.sigma, b.sigma), std::min(a.range, b.range) * view.step * steepest_jump);
    return a.is_hit() && b.is_hit() && std::abs(a.range - b.range) <= limit;
  };
  for (std::size_t first = 0, i = 1; i <= beams.size(); ++i) {
    if (i < beams.size() && follows(i)) continue;
    split(view, first, i - 1, surfaces);
    first = i;
  }
}

std::vector<Surface> find_upright(const std::vector<StillView>& views) {
  std::vector<std::vector<Surface>> by_view;
  for (const StillView& view : views) find_surfaces(view, by_view.emplace_back());
  const auto is_same = [](const Surface& a, const Surface& b) {
    if (std::abs(a.height - b.height) < apart_m ||
        std::abs(angle_between(a.normal, b.normal)) > same_face_rad)
      return false;
    const double s = a.along.dot(b.middle - a.middle);
    return s > a.from && s < a.to && std::abs(a.normal.dot(b.middle - a.middle)) < same_face_m;
  };
  std::vector<Surface> upright;
  for (std::size_t r = 0; r < by_view.size(); ++r) {
    for (const Surface& surface : by_view[r]) {
      bool found = false;
      for (std::size_t other = r - std::min(r, ring_reach);
           other < std::min(by_view.size(), r + ring_reach + 1); ++other) {
        if (other == r) continue;
        found = found || std::any_of(by_view[other].begin(), by_view[other].end(), [&](const Surface& b) {
                  return is_same(surface, b) || is_same(b, surface);
                });
      }
      if (found) upright.push_back(surface);
    }
  }
  return upright;
}

std::vector<LocalLine> local_lines(const StillView& view, const Surface& surface) {
  std::vector<LocalLine> lines;
  const std::size_t count = 2 * local_reach + 1;
  for (std::size_t i = surface.first_beam; i + count - 1 <= surface.last_beam; i += local_reach) {
    const Line line = fit(view.beams, i, i + count - 1);
    const double length = (view.beams[i + count - 1].point - view.beams[i].point).norm();
    const double across =
        view.beams[i + local_reach].sigma * std::abs(line.normal.dot(line.middle.normalized()));
    const double slope = across * std::sqrt(12.0 / static_cast<double>(count)) / std::max(length, 0.01);
    lines.push_back({line.middle, line.normal, slope * slope});
  }
  return lines;
}

}  // namespace lidard
