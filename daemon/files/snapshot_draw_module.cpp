// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What draws pictures is a module, since cairo brings 20 libraries that only `lidard snapshot` needs.
#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "core/base/number_text.h"
#include "daemon/files/snapshot_chart.h"
#include "daemon/files/snapshot_view.h"

namespace lidard {
namespace {

// Okabe and Ito's colours, which people with any colour vision can distinguish; roles differ in shape too.
constexpr std::array<Color, 6> input_colors = {{{0.00, 0.45, 0.70},
                                                {0.84, 0.37, 0.00},
                                                {0.80, 0.47, 0.65},
                                                {0.34, 0.71, 0.91},
                                                {0.55, 0.40, 0.10},
                                                {0.35, 0.25, 0.60}}};
constexpr std::array<Color, 3> merged_colors = {{{0, 0, 0}, {0.90, 0.62, 0.00}, {0.50, 0.50, 0.50}}};
constexpr std::array<Color, 4> virtual_colors = {
    {{0.84, 0.00, 0.45}, {0.45, 0.20, 0.55}, {0.75, 0.35, 0.00}, {0.10, 0.35, 0.35}}};
constexpr Color cloud_color{0.35, 0.35, 0.35};
constexpr Color free_color{0.86, 0.95, 0.89};
constexpr Color unobserved_color{0.91, 0.89, 0.87};
constexpr Color ink{0.13, 0.13, 0.13};
constexpr Color pale{0.45, 0.45, 0.45};

Color color_of(SnapshotView::Role role, std::size_t number) {
  switch (role) {
    case SnapshotView::Role::input:
      return input_colors[number % input_colors.size()];
    case SnapshotView::Role::merged:
      return merged_colors[number % merged_colors.size()];
    case SnapshotView::Role::virtual_scan:
      return virtual_colors[number % virtual_colors.size()];
    case SnapshotView::Role::cloud:
      return cloud_color;
  }
  return ink;
}

/// The least of 1, 2 and 5 times a power of ten that reaches `least`.
double round_step(double least) {
  const double power = std::pow(10, std::floor(std::log10(least)));
  const double lead = least / power;
  return power * (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10);
}

std::string meters(double length) { return printed("%.6g m", length); }

using Role = SnapshotView::Role;
using Align = Chart::Align;
using Eigen::Vector2d;

constexpr double field_left = 20;
constexpr double field_top = 76;
/// Of the field, in pixels.
constexpr double field_area = 760 * 1000;
constexpr double legend_width = 264;
constexpr std::size_t legend_columns = 40;  // letters of a line, beside the symbols
constexpr double name_height = 19, line_height = 17, row_gap = 9;
constexpr double margin = 20;
constexpr double least_ring_gap = 38, most_rings = 5.5;  // pixels; up to the upper edge

/// One row of the legend.
struct LegendRow {
  std::string name;  // empty: none
  std::string note;
  const SnapshotView::Layer* layer = nullptr;  // whose dots or line stand beside it
  std::vector<Color> colors;                   // that fill a box beside it
  Color ink = pale;

  std::vector<std::string> lines() const {
    std::vector<std::string> all;
    std::istringstream words(note);
    for (std::string word; words >> word;) {
      if (all.empty() || all.back().size() + 1 + word.size() > legend_columns)
        all.push_back(word);
      else
        all.back() += " " + word;
    }
    return all;
  }
  double height() const {
    return (name.empty() ? 0 : name_height) + line_height * static_cast<double>(lines().size()) + row_gap;
  }
};

std::vector<LegendRow> legend_of(const SnapshotView& view, double ring_step) {
  std::vector<LegendRow> rows;
  for (const auto& layer : view.layers) rows.push_back({layer.name, layer.note, &layer, {}});
  if (!view.colors_note.empty()) {
    rows.push_back({"colours", view.colors_note, nullptr, {}});
    for (int step = 0; step < 14; ++step) rows.back().colors.push_back(scale_color(step / 13.0));
  }
  if (!view.free_note.empty()) {
    rows.push_back({"free", view.free_note, nullptr, {free_color}});
    rows.push_back({"unknown", view.unobserved_note, nullptr, {unobserved_color}});
    rows.push_back({"",
                    "White: unknown too: behind what was hit, or outside of the scan's angles and range.",
                    nullptr,
                    {}});
  }
  if (!view.fields.empty())
    rows.push_back({"",
                    "Thin lines: fields of view. Dashed: nearer than that no ring of the lidar meets the "
                    "plane of the scan.",
                    nullptr,
                    {}});
  rows.push_back(
      {"", "Ahead is up. Rings: every " + meters(ring_step) + " from " + view.base_frame + ".", nullptr, {}});
  for (const auto* sentences : {&view.notes, &view.missing}) {
    for (const auto& sentence : *sentences) rows.push_back({"", sentence, nullptr, {}, {0.70, 0.20, 0.00}});
  }
  return rows;
}

/// Positions of the parts of a picture, in pixels; the field has the shape of the area shown.
struct Layout {
  double width, height;  // of the field
  double ring_step;      // m
  bool has_legend;
  Layout(const SnapshotView& view, bool with_legend) : has_legend(with_legend) {
    const double aspect = std::clamp(view.framing.half.y() / view.framing.half.x(), 0.65, 1.7);
    width = std::round(std::sqrt(field_area * aspect));
    if (view.framing.width > 0) width = view.framing.width - (page_width() - width);
    height = std::round(width / aspect);
    const Eigen::Vector2d& half = view.framing.half;
    const double pixels_per_meter = std::min(height / half.x(), width / half.y()) / 2;
    ring_step = round_step(std::max(least_ring_gap, height / 2 / most_rings) / pixels_per_meter);
  }
  double legend_left() const { return field_left + width + 22; }
  double page_width() const { return has_legend ? legend_left() + legend_width + 14 : field_left + width; }
};

/// Draws one view.
class Painter {
 public:
  Painter(const SnapshotView& view, const Layout& layout, const std::vector<LegendRow>& legend, Chart& chart)
      : view_(view), layout_(layout), legend_(legend), chart_(chart) {
    chart_.set_field({field_left, field_top}, {layout_.width, layout_.height}, view.framing.center,
                     view.framing.half);
  }
  void paint() {
    chart_.begin_clip();
    areas(true);
    areas(false);
    chart_.begin_marks();
    rings();
    const auto all = [&](Role role) {
      for (auto l = view_.layers.rbegin(); l != view_.layers.rend(); ++l) {
        if (l->role == role) layer(*l);
      }
    };
    clouds();
    fields();
    vehicle();
    all(Role::input);
    all(Role::merged);
    all(Role::virtual_scan);
    for (const auto& one : view_.sensors) sensor(one);
    for (std::size_t i = 0; i < view_.sensors.size(); ++i) sensor_name(view_.sensors[i], i);
    ring_labels();
    chart_.end_clip();
    chart_.rectangle(field_left, field_top, layout_.width, layout_.height);
    chart_.stroke({0.5, 0.5, 0.5}, 1);
    heading();
    if (layout_.has_legend) legend();
  }

 private:
  /// m from the middle of the field to its upper edge.
  double shown() const { return layout_.height / 2 / chart_.pixels_per_meter(); }
  /// All wedges of one kind as one path. Neighbours are joined, else a thin line would show between them.
  void areas(bool observed) {
    const auto& wedges = view_.wedges;
    for (std::size_t i = 0; i < wedges.size();) {
      if (wedges[i].observed != observed) {
        ++i;
        continue;
      }
      chart_.move_to(chart_.to_page(wedges[i].corner[0]));
      for (; i < wedges.size() && wedges[i].observed == observed; ++i) {
        chart_.line_to(chart_.to_page(wedges[i].corner[1]));
        chart_.line_to(chart_.to_page(wedges[i].corner[2]));
      }
      chart_.close();
      chart_.fill(observed ? free_color : unobserved_color);
    }
  }
  void rings() {
    const double step = layout_.ring_step;
    const Vector2d origin = chart_.to_page(Vector2d(0, 0));
    const double reach = view_.framing.center.norm() + shown() * 1.3;
    chart_.begin_crisp();
    for (double r = step; r < reach; r += step) {
      chart_.circle(origin, r * chart_.pixels_per_meter());
      chart_.stroke({0.72, 0.72, 0.72}, 1, {2, 6});
    }
    for (const auto& [dx, dy] : {std::pair{1.0, 0.0}, std::pair{0.0, 1.0}}) {
      const Vector2d along(reach * dx, reach * dy);
      chart_.path({chart_.to_page(Vector2d(-along)), chart_.to_page(along)});
      chart_.stroke({0.80, 0.80, 0.80}, 0.6);
    }
    chart_.end_crisp();
  }
  /// Near to a diagonal, where the axes and usually the vehicle are not.
  void ring_labels() {
    constexpr int candidates = 90;
    for (double r = layout_.ring_step; r < view_.framing.center.norm() + shown() * 1.3;
         r += layout_.ring_step) {
      std::vector<Vector2d> all;
      for (int i = 1; i <= candidates; ++i) {
        const double angle = -0.7 + two_pi / candidates * (i % 2 == 0 ? i / 2 : -(i / 2));
        all.push_back(chart_.to_page(Vector2d(r * std::cos(angle), r * std::sin(angle))));
      }
      chart_.label_where_free(all, meters(r), 12, pale);
    }
  }
  static Color color_at(const SnapshotView::Layer& layer, std::size_t point) {
    if (layer.values.empty()) return color_of(layer.role, layer.number);
    const double lowest = layer.scale.first;
    return scale_color((static_cast<double>(layer.values[point]) - lowest) / (layer.scale.second - lowest));
  }
  void clouds() {
    std::vector<Chart::Dot> dots;
    for (const auto& layer : view_.layers) {
      for (std::size_t i = 0; layer.role == Role::cloud && i < layer.points.size(); ++i)
        dots.push_back({chart_.to_page(layer.points[i]), color_at(layer, i)});
    }
    // Few returns are drawn one by one; many as shades.
    chart_.dots(dots, dots.size() < 60'000 ? 2 : 1, dots.size() < 200'000 ? 1 : 0.6);
  }
  void fields() {
    for (const auto& field : view_.fields) {
      std::vector<Vector2d> border;
      for (const Vector2d& p : field.border) border.push_back(chart_.to_page(p));
      chart_.path(border);
      chart_.close();
      const auto& sensor = view_.sensors[field.sensor];
      const std::vector<double> dashes = field.is_blind ? std::vector<double>{6, 5} : std::vector<double>{};
      chart_.stroke(color_of(sensor.role, sensor.number), 1.2, dashes);
    }
  }
  void layer(const SnapshotView::Layer& layer) {
    if (is_line(layer)) return line(layer);
    for (std::size_t i = 0; i < layer.points.size(); ++i) {
      chart_.dot(chart_.to_page(layer.points[i]));
      if (!layer.values.empty()) chart_.stroke(color_at(layer, i), layer.dot);
    }
    chart_.stroke(color_of(layer.role, layer.number), layer.dot);
  }
  /// Values are shown as dots.
  static bool is_line(const SnapshotView::Layer& layer) {
    return layer.values.empty() && (layer.role == Role::merged || layer.role == Role::virtual_scan);
  }
  void line(const SnapshotView::Layer& layer) {
    bool open = false;
    for (std::size_t i = 0; i < layer.points.size(); ++i) {
      const Vector2d p = chart_.to_page(layer.points[i]);
      const bool begins = !open;
      if (begins)
        chart_.move_to(p);
      else
        chart_.line_to(p);
      open = layer.joined[i] != 0;
      if (begins && !open) chart_.line_to(p);  // a return of its own: a dot
    }
    stroke_line(layer);
  }
  void stroke_line(const SnapshotView::Layer& layer) {
    const Color color = color_of(layer.role, layer.number);
    if (layer.role == Role::virtual_scan) return chart_.stroke(color, 2.2, {7, 5});
    // Further scans of a merge lie below as a wider line, so that their edges show.
    chart_.stroke(color, 1.6 + 2.4 * static_cast<double>(layer.number));
  }
  void vehicle() {
    if (view_.footprint.size() > 2) {
      std::vector<Vector2d> corners;
      for (const Vector2d& corner : view_.footprint) corners.push_back(chart_.to_page(corner));
      chart_.path(corners);
      chart_.close();
      chart_.fill({0.97, 0.97, 0.97, 0.9});
      chart_.path(corners);
      chart_.close();
      chart_.stroke(ink, 1.6);
    }
    const double m = chart_.pixels_per_meter();
    const Vector2d o = chart_.to_page(Vector2d(0, 0));
    const double arrow = std::clamp(0.9 * m, 14.0, 40.0);
    const Vector2d tip = o - Vector2d(0, arrow);
    chart_.path({o, tip, tip + Vector2d(-4, 7)});
    chart_.path({tip, tip + Vector2d(4, 7)});
    chart_.stroke(ink, 1.6);
    chart_.circle(o, 2.5);
    chart_.fill(ink);
  }
  void sensor(const SnapshotView::Sensor& sensor) {
    chart_.circle(chart_.to_page(sensor.at), 4);
    chart_.fill(color_of(sensor.role, sensor.number));
  }
  void sensor_name(const SnapshotView::Sensor& sensor, std::size_t index) {
    const Color color = color_of(sensor.role, sensor.number);
    const Vector2d at = chart_.to_page(sensor.at);
    // Names stand beside the vehicle, on the sensor's side.
    const bool left = sensor.at.y() > 0.05 || (std::abs(sensor.at.y()) <= 0.05 && index % 2 == 1);
    const Vector2d beside = at + Vector2d(left ? -10 : 10, sensor.at.x() < -0.5 ? 14 : -6);
    chart_.label(beside, sensor.name, 13, color, left ? Align::right : Align::left);
  }
  void heading() {
    chart_.text({field_left, 34}, view_.title, 21, ink, Align::left, true);
    chart_.text({field_left, 58}, view_.subtitle, 14, pale);
  }
  void legend() {
    double y = field_top + 14;
    for (const LegendRow& row : legend_) {
      swatch(row, {layout_.legend_left(), y});
      double baseline = y;
      const double left = layout_.legend_left() + 38;
      if (!row.name.empty()) {
        chart_.text({left, baseline}, row.name, 14, ink, Align::left, true);
        baseline += name_height;
      }
      for (const std::string& line : row.lines()) {
        chart_.text({left, baseline}, line, 11, row.ink);
        baseline += line_height;
      }
      y += row.height();
    }
  }
  /// Draws the symbol of a legend row before its first line.
  void swatch(const LegendRow& row, const Vector2d& at) {
    const double width = 28 / std::max<double>(1, static_cast<double>(row.colors.size()));
    for (std::size_t i = 0; i < row.colors.size(); ++i) {
      chart_.rectangle(at.x() + width * static_cast<double>(i), at.y() - 13, width, 18);
      chart_.fill(row.colors[i]);
    }
    if (row.layer == nullptr) return;
    if (is_line(*row.layer)) {
      chart_.path({at - Vector2d(0, 5), at + Vector2d(28, -5)});
      return stroke_line(*row.layer);
    }
    for (const double share : {0.1, 0.5, 0.9}) {
      chart_.dot(at + Vector2d(4 + 20 * share, -5));
      chart_.stroke(
          row.layer->values.empty() ? color_of(row.layer->role, row.layer->number) : scale_color(share), 6);
    }
  }

  const SnapshotView& view_;
  const Layout& layout_;
  const std::vector<LegendRow>& legend_;
  Chart& chart_;
};

std::string drawn(const std::vector<SnapshotView>& views, PictureFormat format) {
  const SnapshotView& last = views.back();
  std::vector<Layout> layouts;
  layouts.reserve(views.size());
  for (const SnapshotView& view : views) layouts.emplace_back(view, &view == &last);
  const std::vector<LegendRow> legend = legend_of(last, layouts.back().ring_step);
  double width = 0, height = field_top;
  std::string description = last.subtitle;
  for (const LegendRow& row : legend) {
    height += row.height();
    description += "\n" + row.name + (row.name.empty() ? "" : ": ") + row.note;
  }
  for (const Layout& layout : layouts)
    width += layout.page_width(), height = std::max(height, field_top + layout.height);
  Chart chart(format, width, std::ceil(height + margin));
  for (std::size_t i = 0; i < views.size(); ++i) {
    Painter(views[i], layouts[i], legend, chart).paint();
    chart.shift(layouts[i].page_width());
  }
  return chart.bytes(last.title, description);
}

}  // namespace

}  // namespace lidard

extern "C" void lidard_draw_snapshot(const std::vector<lidard::SnapshotView>& views,
                                     lidard::PictureFormat format, std::string& bytes) {
  bytes = lidard::drawn(views, format);
}
