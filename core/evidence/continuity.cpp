// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "core/evidence/placed_scan.h"

namespace lidard {
namespace {

using namespace breakpoint;
constexpr float along_beam_sine = 0.2079117F;  // sine of 12 degrees
constexpr float sharpest_bend = 0.34F;         // sine of 20 degrees; less is noise or a curve
constexpr float shortest_bridge = 0.1F;        // m
constexpr float bridge_sine = 0.4226183F;      // sine of 25 degrees
constexpr float bridge_cosine = 0.9063078F;

struct Point {
  float x, y;
};

Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
float cross(Point a, Point b) { return a.x * b.y - a.y * b.x; }
float square(Point a) { return a.x * a.x + a.y * a.y; }
float length(Point a) { return std::sqrt(square(a)); }

/// The returns of one sweep in the scanner's own plane.
class Returns {
 public:
  Returns(const BeamRays& rays, double noise, const PlacedScan& sweep)
      : rays_(rays), sweep_(sweep), noise_(static_cast<float>(noise)) {}

  bool has(std::size_t i) const { return i < sweep_.kind.size() && sweep_.kind[i] != Return::nothing; }
  Point at(std::size_t i) const {
    return {sweep_.range[i] * rays_.cosine[i], sweep_.range[i] * rays_.sine[i]};
  }
  float tolerance() const { return 3 * noise_ + line_tolerance; }
  /// True if `middle` lies on the line through the two others.
  bool in_line(Point a, Point middle, Point b) const {
    const Point line = b - a;
    return std::fabs(cross(line, middle - a)) <= tolerance() * length(line);
  }
  /// True if the four returns around the pair (i, i + 1) lie on one line with steadily growing steps: a
  /// grazing wall.
  bool grazing(std::size_t i) const {
    if (i == 0 || !has(i - 1) || !has(i + 2)) return false;
    const Point a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
    const float step = length(c - b);
    if (step > longest_grazing_step) return false;
    if (step > steady_growth * std::max(length(b - a), length(d - c))) return false;
    return in_line(a, b, d) && in_line(a, c, d);
  }
  /// True if the step from `side` to i continues the line from `beyond` to `side`.
  bool continues(std::size_t beyond, std::size_t side, std::size_t i) const {
    if (!has(beyond) || !has(side)) return false;
    const Point a = at(beyond), b = at(side), c = at(i);
    if (length(c - b) > steady_growth * std::max(length(b - a), 6 * noise_)) return false;
    return in_line(a, b, c);
  }
  /// True if the line from return i to its neighbour makes less than 12 degrees with the beam.
  bool along_beam(std::size_t i, std::size_t neighbour) const {
    const Point step = at(neighbour) - at(i);
    const float across = cross({rays_.cosine[i], rays_.sine[i]}, step);
    return across * across < along_beam_sine * along_beam_sine * square(step);
  }

 private:
  const BeamRays& rays_;
  const PlacedScan& sweep_;
  float noise_;
};

bool is_between(float a, float middle, float b) {
  return (a < middle && middle < b) || (b < middle && middle < a);
}

bool is_mixed_pixel(const Returns& returns, const PlacedScan& sweep, std::size_t i) {
  if (!returns.has(i - 1) || !returns.has(i) || !returns.has(i + 1)) return false;
  if (!is_between(sweep.range[i - 1], sweep.range[i], sweep.range[i + 1])) return false;
  const bool alone = sweep.linked[i - 1] == 0 && sweep.linked[i] == 0;
  if (!alone && !(returns.along_beam(i, i - 1) && returns.along_beam(i, i + 1))) return false;
  if (i >= 2 && returns.continues(i - 2, i - 1, i)) return false;
  return !returns.continues(i + 2, i + 1, i);
}

/// True if the link from i to i + 1 leads steeply from one surface to another and both continue on other
/// lines.
bool is_bridge(const Returns& returns, const BeamRays& rays, const PlacedScan& sweep, std::size_t i,
               float shortest) {
  if (sweep.linked[i - 1] == 0 || sweep.linked[i] == 0 || sweep.linked[i + 1] == 0) return false;
  if (std::fabs(sweep.range[i] - sweep.range[i + 1]) < shortest * bridge_cosine) return false;
  const Point b = returns.at(i), c = returns.at(i + 1);
  const Point step = c - b;
  if (length(step) < shortest) return false;
  if (std::fabs(cross({rays.cosine[i], rays.sine[i]}, step)) >= bridge_sine * length(step)) return false;
  return !returns.in_line(returns.at(i - 1), b, c) && !returns.in_line(b, c, returns.at(i + 2));
}

void cut_bridges(const Returns& returns, const BeamRays& rays, double noise, PlacedScan& sweep) {
  const float shortest = std::max(shortest_bridge, static_cast<float>(5 * noise));
  bool before = false;  // the link before is a bridge; it is removed after this link was judged
  for (std::size_t i = 1; i + 2 < sweep.linked.size(); ++i) {
    const bool bridge = is_bridge(returns, rays, sweep, i, shortest);
    if (before) sweep.linked[i - 1] = 0;
    before = bridge;
    if (bridge && i + 3 >= sweep.linked.size()) sweep.linked[i] = 0;
  }
}

/// Marks links of which a return and a nearer one may belong to two things: nothing but the two returns says
/// that there is a surface between them.
void find_near_links(const Returns& returns, double noise, PlacedScan& sweep) {
  const float shortest = std::max(shortest_bridge, static_cast<float>(5 * noise));
  for (std::size_t i = 0; i + 1 < sweep.linked.size(); ++i) {
    if (sweep.linked[i] == 0 || std::fabs(sweep.range[i] - sweep.range[i + 1]) < shortest) continue;
    const Point b = returns.at(i), c = returns.at(i + 1);
    const bool before = i > 0 && sweep.linked[i - 1] != 0 && returns.in_line(returns.at(i - 1), b, c);
    const bool after =
        i + 2 < sweep.linked.size() && sweep.linked[i + 1] != 0 && returns.in_line(b, c, returns.at(i + 2));
    if (!before && !after) sweep.linked[i] = PlacedScan::near;
  }
}

}  // namespace

void link_neighbours(const BeamRays& rays, double noise, PlacedScan& sweep) {
  const std::size_t n = sweep.range.size();
  const double step = std::abs(rays.increment);
  const auto slope = step < steepest / 2 ? static_cast<float>(std::sin(step) / std::sin(steepest - step)) : 0;
  const auto spread = static_cast<float>(2 * (1 - std::cos(step)));
  const auto slack = static_cast<float>(3 * noise);
  const Returns returns(rays, noise, sweep);
  sweep.linked.assign(n, PlacedScan::apart);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    if (sweep.kind[i] == Return::nothing || sweep.kind[i + 1] == Return::nothing) continue;
    const float a = sweep.range[i];
    const float b = sweep.range[i + 1];
    const float limit = std::min(a, b) * slope + slack;
    // The chord squared, without the cancellation of the cosine rule.
    const float squared = (a - b) * (a - b) + a * b * spread;
    if (squared <= limit * limit || returns.grazing(i)) sweep.linked[i] = PlacedScan::linked_surely;
  }
  cut_bridges(returns, rays, noise, sweep);
  find_near_links(returns, noise, sweep);
}

void mark_mixed_pixels(const BeamRays& rays, double noise, PlacedScan& sweep) {
  const std::size_t n = sweep.range.size();
  const Returns returns(rays, noise, sweep);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (sweep.linked[i - 1] != 0 && sweep.linked[i] != 0 && !returns.along_beam(i, i - 1)) continue;
    if (!is_mixed_pixel(returns, sweep, i)) continue;
    sweep.kind[i] = Return::mixed_pixel;
    ++sweep.mixed_pixels;
  }
  for (std::size_t i = 0; i + 1 < n; ++i) {
    if (sweep.kind[i] == Return::mixed_pixel || sweep.kind[i + 1] == Return::mixed_pixel) sweep.linked[i] = 0;
  }
}

void find_corners(double noise, PlacedScan& sweep) {
  sweep.corners.clear();
  const auto shortest = static_cast<float>(10 * noise);
  const auto at = [&](std::size_t i) { return Point{sweep.x[i], sweep.y[i]}; };
  for (std::size_t i = 1; i + 2 < sweep.linked.size(); ++i) {
    if (sweep.linked[i - 1] == 0 || sweep.linked[i] == 0 || sweep.linked[i + 1] == 0) continue;
    const Point b = at(i), c = at(i + 1);
    const Point before = b - at(i - 1), after = at(i + 2) - c, across = c - b;
    const float bend = cross(before, after);
    const float both = square(before) * square(after);
    if (bend * bend < sharpest_bend * sharpest_bend * both) continue;
    if (both < shortest * shortest * shortest * shortest) continue;
    // b + t * before meets c - u * after.
    const float t = cross(across, after) / bend;
    const float u = cross(before, across) / bend;
    if (t <= 0 || u <= 0 || t * length(before) > length(across) || u * length(after) > length(across))
      continue;
    const float intensity = sweep.intensity.empty() ? 0 : (sweep.intensity[i] + sweep.intensity[i + 1]) / 2;
    sweep.corners.push_back({i, {b.x + t * before.x, b.y + t * before.y, intensity}});
  }
}

}  // namespace lidard
