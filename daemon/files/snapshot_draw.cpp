// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/files/snapshot_style.h"

namespace lidard {
namespace {

using Role = SnapshotView::Role;
using Align = Chart::Align;
using Eigen::Vector2d;

constexpr double field_left = 20;
constexpr double field_top = 76;
/// Of the field, in pixels.
constexpr double field_area = 760 * 1000;
constexpr double legend_width = 264;
constexpr double margin = 20;
constexpr double side_caption = 34;
constexpr const char* white_note =
    "White: unknown too: behind what was hit, or outside of the scan's angles and range.";

/// Where the parts of a picture stand, in pixels: the field as wide and high as what it shows.
struct Layout {
  double width, height;  // of the field
  double side;           // height of the side view; 0: there is none
  explicit Layout(const SnapshotView& view) {
    const double aspect = std::clamp(view.framing.half.y() / view.framing.half.x(), 0.65, 1.7);
    width = std::round(std::sqrt(field_area * aspect));
    if (view.framing.width > 0) width = view.framing.width - (page_width() - width);
    height = std::round(width / aspect);
    side = std::round(side_height(view, width));
  }
  double legend_left() const { return field_left + width + 22; }
  double page_width() const { return legend_left() + legend_width + 14; }
  double side_top() const { return field_top + height + side_caption; }
  double bottom() const { return side > 0 ? side_top() + side : field_top + height; }
};

/// Draws one view.
class Painter {
 public:
  Painter(const SnapshotView& view, PictureFormat format, double page_height)
      : view_(view), layout_(view), chart_(format, layout_.page_width(), page_height) {
    chart_.set_field({field_left, field_top}, {layout_.width, layout_.height}, view.framing.center,
                     view.framing.half);
  }
  /// Pixels that the page needs: the views or the legend, whichever is longer.
  static double page_height(const SnapshotView& view) {
    Painter trial(view, PictureFormat::png, 1);
    trial.legend();
    return std::ceil(std::max(trial.layout_.bottom(), trial.legend_y_) + margin);
  }
  std::string bytes() {
    paint();
    return chart_.bytes(view_.title, description());
  }

 private:
  void paint() {
    chart_.begin_clip();
    areas(true);
    areas(false);
    for (const auto& wedge : view_.wedges) {
      if (wedge.observed) continue;
      chart_.path({chart_.to_page(wedge.corner[0]), chart_.to_page(wedge.corner[1]),
                   chart_.to_page(wedge.corner[2])});
      chart_.close();
    }
    chart_.hatch(hatch_color, 9);
    rings();
    const auto all = [&](Role role) {
      for (auto l = view_.layers.rbegin(); l != view_.layers.rend(); ++l) {
        if (l->role == role) layer(*l);
      }
    };
    clouds();
    vehicle();
    all(Role::input);
    all(Role::merged);
    all(Role::virtual_scan);
    scale_bar();
    for (std::size_t i = 0; i < view_.sensors.size(); ++i) sensor(view_.sensors[i], i);
    for (std::size_t i = 0; i < view_.sensors.size(); ++i) sensor_name(view_.sensors[i], i);
    ring_labels();
    chart_.end_clip();
    chart_.rectangle(field_left, field_top, layout_.width, layout_.height);
    chart_.stroke({0.5, 0.5, 0.5}, 1);
    heading();
    legend();
    if (layout_.side > 0) draw_side(chart_, view_, {field_left, layout_.side_top()}, layout_.width);
  }

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
    const double step = round_step(shown(), 4.5);
    const Vector2d origin = chart_.to_page(Vector2d(0, 0));
    const double reach = view_.framing.center.norm() + shown() * 1.3;
    chart_.begin_crisp();
    for (double r = step; r < reach; r += step) {
      chart_.circle(origin, r * chart_.pixels_per_meter());
      chart_.stroke({0.72, 0.72, 0.72}, 1, {2, 6});
    }
    chart_.end_crisp();
    for (const auto& [dx, dy] : {std::pair{1.0, 0.0}, std::pair{0.0, 1.0}}) {
      const Vector2d along(reach * dx, reach * dy);
      chart_.path({chart_.to_page(Vector2d(-along)), chart_.to_page(along)});
      chart_.stroke({0.80, 0.80, 0.80}, 0.6);
    }
  }
  /// On a diagonal, where the axes and usually the vehicle are not.
  void ring_labels() {
    const double step = round_step(shown(), 4.5);
    const Vector2d along(std::cos(-0.7), std::sin(-0.7));
    for (double r = step; r < view_.framing.center.norm() + shown() * 1.3; r += step)
      chart_.label(chart_.to_page(Vector2d(r * along)), meters(r), 12, pale, Align::middle);
  }
  /// Share of the colours' scale.
  double share(float value) const {
    const auto& f = view_.framing;
    return (static_cast<double>(value) - f.lowest) / (f.highest - f.lowest);
  }
  void clouds() {
    std::vector<Chart::Dot> dots;
    for (const auto& layer : view_.layers) {
      for (std::size_t i = 0; i < layer.values.size(); ++i)
        dots.push_back({chart_.to_page(layer.points[i]), scale_color(share(layer.values[i]))});
    }
    // A few returns are big dots, many make shades.
    chart_.dots(dots, dots.size() < 60'000 ? 2 : 1, dots.size() < 200'000 ? 0.85 : 0.6);
  }
  void layer(const SnapshotView::Layer& layer) {
    const Color color = color_of(layer.role, layer.number);
    if (layer.role == Role::merged || layer.role == Role::virtual_scan) return line(layer);
    for (const auto& p : layer.points) chart_.dot(chart_.to_page(p));
    chart_.stroke(color, 6);
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
  /// Of the outline of its field of view; radii differ, so that sensors in one place can be told apart.
  static double radius_of(std::size_t index) { return 26 + 7 * static_cast<double>(index % 4); }
  void sensor(const SnapshotView::Sensor& sensor, std::size_t index) {
    const Color color = color_of(sensor.role, sensor.number);
    const Vector2d at = chart_.to_page(sensor.at);
    std::vector<Vector2d> outline;
    if (!sensor.all_round) outline.push_back(at);
    for (const Vector2d& direction : sensor.field)
      outline.emplace_back(at + radius_of(index) * Vector2d(-direction.y(), -direction.x()));
    chart_.path(outline);
    chart_.close();
    chart_.stroke(color, 1.4);
    chart_.circle(at, 4);
    chart_.fill(color);
  }
  void sensor_name(const SnapshotView::Sensor& sensor, std::size_t index) {
    const Color color = color_of(sensor.role, sensor.number);
    const Vector2d at = chart_.to_page(sensor.at);
    const double radius = radius_of(index);
    if (sensor.all_round)
      return chart_.name(at - Vector2d(0, radius + 5), sensor.name, 13, color, Align::middle);
    // Names stand beside the vehicle, on the sensor's side.
    const bool left = sensor.at.y() > 0.05 || (std::abs(sensor.at.y()) <= 0.05 && index % 2 == 1);
    const Vector2d place = at + Vector2d(left ? -radius - 6 : radius + 6, sensor.at.x() < -0.5 ? 14 : -6);
    chart_.name(place, sensor.name, 13, color, left ? Align::right : Align::left);
  }
  void scale_bar() {
    const double length = round_step(shown(), 5);
    const double pixels = length * chart_.pixels_per_meter();
    const double x = field_left + 16;
    const double y = field_top + layout_.height - 16;
    chart_.rectangle(x - 8, y - 26, pixels + 16, 36);
    chart_.fill({1, 1, 1, 0.85});
    chart_.path({{x, y - 5}, {x, y}, {x + pixels, y}, {x + pixels, y - 5}});
    chart_.stroke(ink, 1.6);
    chart_.text({x + pixels / 2, y - 9}, meters(length), 12, ink, Align::middle);
  }
  void heading() {
    chart_.text({field_left, 34}, view_.title, 21, ink, Align::left, true);
    chart_.text({field_left, 58}, view_.subtitle, 14, pale);
  }
  void legend() {
    legend_y_ = field_top + 14;
    const auto group = [&](const char* heading, Role role) {
      bool any = false;
      for (const auto& layer : view_.layers) {
        if (layer.role != role) continue;
        if (!any) legend_text(heading, 12, pale), legend_y_ += 6;
        any = true;
        legend_layer(layer);
      }
      if (any) legend_y_ += 8;
    };
    group("SCANNERS", Role::input);
    group("CLOUDS", Role::cloud);
    if (!view_.fans.empty()) legend_scale();
    group("MERGED SCANS", Role::merged);
    group("VIRTUAL SCANS", Role::virtual_scan);
    if (!view_.free_note.empty()) {
      legend_text("AREAS", 12, pale);
      legend_y_ += 6;
      legend_area("free", view_.free_note, true);
      legend_area("unknown", view_.unobserved_note, false);
      legend_text(white_note, 12, pale, 38);
      legend_y_ += 8;
    }
    legend_text("Ahead is up. Rings: distance from " + view_.base_frame +
                    ". Outline around a sensor: its field of view, not to scale.",
                12, pale);
    legend_y_ += 8;
    for (const auto* sentences : {&view_.notes, &view_.missing}) {
      for (const auto& sentence : *sentences) {
        legend_text(sentence, 12, {0.70, 0.20, 0.00});
        legend_y_ += 4;
      }
    }
  }
  void legend_scale() {
    const double left = layout_.legend_left() + 38, width = legend_width - 60, y = legend_y_ - 12;
    constexpr int steps = 60;
    for (int i = 0; i < steps; ++i) {
      chart_.rectangle(left + width * i / steps, y, width / steps + 0.6, 14);
      chart_.fill(scale_color((i + 0.5) / steps));
    }
    const auto number = [](double value) { return printed("%.3g", std::abs(value) < 5e-4 ? 0.0 : value); };
    const auto& f = view_.framing;
    chart_.text({left, y + 28}, number(f.lowest), 12, ink);
    chart_.text({left + width / 2, y + 28}, number((f.lowest + f.highest) / 2), 12, ink, Align::middle);
    chart_.text({left + width, y + 28}, number(f.highest), 12, ink, Align::right);
    legend_y_ = y + 45;
    legend_text(view_.color_words, 12, pale, 38);
    legend_y_ += 14;
  }
  void legend_layer(const SnapshotView::Layer& layer) {
    const Color color = color_of(layer.role, layer.number);
    const double y = legend_y_ - 5;
    if (layer.role == Role::input || layer.role == Role::cloud) {
      for (const double share : {0.1, 0.5, 0.9}) {
        chart_.dot({layout_.legend_left() + 4 + 20 * share, y});
        chart_.stroke(layer.role == Role::cloud ? scale_color(share) : color, 6);
      }
    } else {
      chart_.path({{layout_.legend_left(), y}, {layout_.legend_left() + 28, y}});
      stroke_line(layer);
    }
    legend_entry(layer.name, layer.note);
  }
  void legend_entry(const std::string& name, const std::string& note) {
    legend_text(name, 14, ink, 38, true);
    legend_text(note, 12, pale, 38);
    legend_y_ += 9;
  }
  void legend_area(const std::string& name, const std::string& note, bool observed) {
    chart_.rectangle(layout_.legend_left(), legend_y_ - 13, 28, 18);
    chart_.fill(observed ? free_color : unobserved_color);
    chart_.rectangle(layout_.legend_left(), legend_y_ - 13, 28, 18);
    if (!observed) chart_.hatch(hatch_color, 7);
    chart_.rectangle(layout_.legend_left(), legend_y_ - 13, 28, 18);
    chart_.stroke({0.6, 0.6, 0.6}, 0.8);
    legend_entry(name, note);
  }
  /// Writes words into the legend, in as many lines as they need.
  void legend_text(const std::string& words, double size, const Color& color, double indent = 0,
                   bool bold = false) {
    std::string row;
    const auto put = [&] {
      if (row.empty()) return;
      chart_.text({layout_.legend_left() + indent, legend_y_}, row, size, color, Align::left, bold);
      legend_y_ += size + 5;
      row.clear();
    };
    for (std::size_t begin = 0; begin < words.size();) {
      const std::size_t end = std::min(words.find(' ', begin), words.size());
      const std::string word = words.substr(begin, end - begin);
      const std::string longer = row.empty() ? word : row + " " + word;
      if (chart_.text_width(longer, size, bold) > legend_width - indent) put();
      row = row.empty() ? word : row + " " + word;
      begin = end + 1;
    }
    put();
  }
  std::string description() const {
    std::string text = view_.subtitle;
    for (const auto& layer : view_.layers) text += "\n" + layer.name + ": " + layer.note;
    for (const auto& sensor : view_.sensors) text += "\nsensor " + sensor.name;
    if (!view_.free_note.empty())
      text += "\nfree: " + view_.free_note + "\nunknown: " + view_.unobserved_note + "\n" + white_note;
    for (const auto* sentences : {&view_.notes, &view_.missing}) {
      for (const auto& sentence : *sentences) text += "\n" + sentence;
    }
    return text;
  }

  const SnapshotView& view_;
  Layout layout_;
  Chart chart_;
  double legend_y_ = 0;
};

}  // namespace

std::string draw_snapshot(const SnapshotView& view, PictureFormat format) {
  return Painter(view, format, Painter::page_height(view)).bytes();
}

}  // namespace lidard
