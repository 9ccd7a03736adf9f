// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The view from the right side below a picture: lidars, ground and planes, and objects near the middle line.
#include <cmath>

#include "daemon/files/snapshot_style.h"

namespace lidard {
namespace {

using Eigen::Vector2d;
using Role = SnapshotView::Role;

/// Pixels.
constexpr double least_height = 120, most_height = 280;

struct SideScale {
  double pixels_per_meter = 1;
  double stretch = 1;  // of heights
  double height = 0;   // pixels
};

/// Same extent ahead and behind as the view from above; small heights are stretched.
SideScale scale_of(const SnapshotView& view, double width) {
  SideScale scale;
  const double span = view.framing.high - view.framing.low;
  if (!(span > 0)) return scale;
  scale.pixels_per_meter = std::min(width / (2 * view.framing.half.x()), most_height / span);
  scale.stretch = std::round(std::clamp(least_height / (span * scale.pixels_per_meter), 1.0, 10.0));
  scale.height = std::clamp(span * scale.pixels_per_meter * scale.stretch, least_height / 2, most_height);
  return scale;
}

class SidePainter {
 public:
  SidePainter(Chart& chart, const SnapshotView& view, const Vector2d& corner, double width)
      : chart_(chart),
        view_(view),
        scale_(scale_of(view, width)),
        corner_(corner),
        size_(width, scale_.height) {
    const Vector2d center(scale_.stretch * (view.framing.low + view.framing.high) / 2,
                          -view.framing.center.x());
    chart_.set_field(corner_, size_, center,
                     {size_.y() / 2 / scale_.pixels_per_meter, size_.x() / 2 / scale_.pixels_per_meter});
  }
  void paint() {
    constexpr Color ground_color{0.45, 0.30, 0.15};
    chart_.begin_clip();
    grid();
    clouds();
    if (view_.ground) {
      chart_.path({at({left(), *view_.ground}), at({right(), *view_.ground})});
      chart_.stroke(ground_color, 1.6);
    }
    for (const auto& plane : view_.planes) plane_line(plane);
    for (const Vector2d& lidar : view_.lidars) {
      chart_.circle(at(lidar), 4);
      chart_.fill(cloud_color);
    }
    if (view_.ground) chart_.label(at({left(), *view_.ground}) + Vector2d(8, -4), "ground", 12, ground_color);
    for (const auto& plane : view_.planes) plane_name(plane);
    chart_.end_clip();
    chart_.rectangle(corner_.x(), corner_.y(), size_.x(), size_.y());
    chart_.stroke({0.5, 0.5, 0.5}, 1);
    caption();
  }

 private:
  /// From x and z to the page.
  Vector2d at(const Vector2d& p) const { return chart_.to_page(Vector2d(scale_.stretch * p.y(), -p.x())); }
  double reach() const { return size_.x() / 2 / scale_.pixels_per_meter; }
  double left() const { return view_.framing.center.x() - reach(); }
  double right() const { return view_.framing.center.x() + reach(); }

  /// Heights, that of base_frame darker.
  void grid() {
    const double step = round_step(view_.framing.high - view_.framing.low, 4);
    for (double z = std::ceil(view_.framing.low / step) * step; z < view_.framing.high; z += step) {
      const bool base = std::abs(z) < step / 2;
      chart_.path({at({left(), z}), at({right(), z})});
      chart_.stroke(base ? Color{0.55, 0.55, 0.55} : Color{0.85, 0.85, 0.85}, base ? 1 : 0.7);
      chart_.label(at({right(), z}) + Vector2d(-6, -3), base ? "0 m, " + view_.base_frame : meters(z), 11,
                   pale, Chart::Align::right);
    }
  }
  void clouds() {
    const auto& f = view_.framing;
    std::vector<Chart::Dot> dots;
    for (const auto& layer : view_.layers) {
      for (std::size_t i = 0; i < layer.heights.size(); ++i) {
        if (std::abs(static_cast<double>(layer.points[i].y())) > SnapshotView::side_strip) continue;
        const Vector2d p(static_cast<double>(layer.points[i].x()), static_cast<double>(layer.heights[i]));
        dots.push_back(
            {at(p), scale_color((static_cast<double>(layer.values[i]) - f.lowest) / (f.highest - f.lowest))});
      }
    }
    chart_.dots(dots, 3, 0.9);
  }
  void plane_line(const SnapshotView::Plane& plane) {
    const Color color = color_of(plane.role, plane.number);
    const Vector2d along = 4 * reach() * plane.along;
    chart_.path({at(plane.at - along), at(plane.at + along)});
    if (plane.role == Role::virtual_scan)
      chart_.stroke(color, 1.8, {7, 5});
    else
      chart_.stroke(color, 1);
    chart_.circle(at(plane.at), 3);
    chart_.fill(color);
  }
  void plane_name(const SnapshotView::Plane& plane) {
    const double x = left() + 8 / scale_.pixels_per_meter;
    const bool steep = std::abs(plane.along.x()) < 0.2;
    const double z = plane.at.y() + (steep ? 0 : plane.along.y() / plane.along.x() * (x - plane.at.x()));
    chart_.label(at({x, z}) + Vector2d(0, -4), plane.name, 12, color_of(plane.role, plane.number));
  }
  void caption() {
    std::string words = "From the right, y within " + meters(SnapshotView::side_strip);
    if (scale_.stretch > 1) words += printed(", heights x %g", scale_.stretch);
    chart_.text(corner_ + Vector2d(0, -8), words, 13, pale);
  }

  Chart& chart_;
  const SnapshotView& view_;
  SideScale scale_;
  Vector2d corner_, size_;
};

}  // namespace

double side_height(const SnapshotView& view, double width) { return scale_of(view, width).height; }

void draw_side(Chart& chart, const SnapshotView& view, const Vector2d& corner, double width) {
  SidePainter(chart, view, corner, width).paint();
}

}  // namespace lidard
