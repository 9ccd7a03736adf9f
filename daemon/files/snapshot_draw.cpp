// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>

#include "daemon/files/snapshot_chart.h"

namespace lidard {
namespace {

/// Pixels of the picture's side.
constexpr double snapshot_side = 1200;

using Role = SnapshotView::Role;
using Align = Chart::Align;
using Eigen::Vector2d;

// Okabe and Ito's colours, which people with any colour vision tell apart; roles differ in shape too.
constexpr std::array<Color, 6> input_colors = {{{0.00, 0.45, 0.70},
                                                {0.84, 0.37, 0.00},
                                                {0.80, 0.47, 0.65},
                                                {0.34, 0.71, 0.91},
                                                {0.55, 0.40, 0.10},
                                                {0.35, 0.25, 0.60}}};
constexpr std::array<Color, 3> merged_colors = {{{0, 0, 0}, {0.90, 0.62, 0.00}, {0.50, 0.50, 0.50}}};
constexpr std::array<Color, 4> virtual_colors = {
    {{0.00, 0.62, 0.45}, {0.45, 0.20, 0.55}, {0.75, 0.10, 0.20}, {0.10, 0.35, 0.35}}};
constexpr Color cloud_color{0.55, 0.55, 0.55};
constexpr Color free_color{0.86, 0.95, 0.89};
constexpr Color unobserved_color{0.91, 0.89, 0.87};
constexpr Color hatch_color{0.70, 0.66, 0.63};
constexpr Color ink{0.13, 0.13, 0.13};
constexpr Color pale{0.45, 0.45, 0.45};

constexpr double field_left = 20;
constexpr double field_top = 76;
constexpr double field_width = 880;
constexpr double field_height = 1104;
constexpr double legend_left = field_left + field_width + 22;
constexpr double legend_width = snapshot_side - legend_left - 14;

Color color_of(Role role, std::size_t number) {
  switch (role) {
    case Role::input:
      return input_colors[number % input_colors.size()];
    case Role::merged:
      return merged_colors[number % merged_colors.size()];
    case Role::virtual_scan:
      return virtual_colors[number % virtual_colors.size()];
    case Role::cloud:
      return cloud_color;
  }
  return ink;
}

/// 1, 2 or 5 times a power of ten, such that about `parts` of them make `length`.
double round_step(double length, double parts) {
  const double rough = length / parts;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  const double lead = rough / power;
  return power * (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10);
}

std::string meters(double length) {
  std::string text = std::to_string(length);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text + " m";
}

/// Draws one view.
class Painter {
 public:
  Painter(const SnapshotView& view, PictureFormat format)
      : view_(view), chart_(format, snapshot_side, snapshot_side) {
    chart_.set_field({field_left, field_top}, {field_width, field_height}, view.center, view.half);
  }
  std::string paint() {
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
    all(Role::cloud);
    vehicle();
    all(Role::input);
    all(Role::merged);
    all(Role::virtual_scan);
    for (std::size_t i = 0; i < view_.sensors.size(); ++i) sensor(view_.sensors[i], i);
    scale_bar();
    chart_.end_clip();
    chart_.rectangle(field_left, field_top, field_width, field_height);
    chart_.stroke({0.5, 0.5, 0.5}, 1);
    heading();
    legend();
    return chart_.bytes(view_.title, description());
  }

 private:
  /// m from the middle of the field to its upper edge.
  double shown() const { return field_height / 2 / chart_.pixels_per_meter(); }
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
    const double reach = view_.center.norm() + shown() * 1.3;
    for (double r = step; r < reach; r += step) {
      chart_.circle(origin, r * chart_.pixels_per_meter());
      chart_.stroke({0.62, 0.62, 0.62}, 0.7, {2, 4});
    }
    for (const auto& [dx, dy] : {std::pair{1.0, 0.0}, std::pair{0.0, 1.0}}) {
      const Vector2d along(reach * dx, reach * dy);
      chart_.path({chart_.to_page(Vector2d(-along)), chart_.to_page(along)});
      chart_.stroke({0.80, 0.80, 0.80}, 0.6);
    }
    // On a diagonal, where the axes and usually the vehicle are not.
    const double angle = -0.7;
    for (double r = step; r < reach; r += step) {
      const Vector2d at = chart_.to_page(Vector2d(r * std::cos(angle), r * std::sin(angle)));
      if (at.x() < field_left + field_width - 24 && at.y() > field_top + 14)
        chart_.label(at, meters(r), 12, pale, Align::middle);
    }
  }
  void layer(const SnapshotView::Layer& layer) {
    const Color color = color_of(layer.role, layer.number);
    if (layer.role == Role::merged || layer.role == Role::virtual_scan) return line(layer);
    for (const auto& p : layer.points) chart_.dot(chart_.to_page(p));
    if (layer.role == Role::cloud) return chart_.stroke({color.red, color.green, color.blue, 0.8}, 1.5);
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
  void sensor(const SnapshotView::Sensor& sensor, std::size_t index) {
    const Color color =
        sensor.role == Role::cloud ? Color{0.35, 0.35, 0.35} : color_of(sensor.role, sensor.number);
    const Vector2d at = chart_.to_page(sensor.at);
    // Radii differ, so that sensors in one place can be told apart.
    const double radius = 26 + 7 * static_cast<double>(index % 4);
    std::vector<Vector2d> outline;
    if (!sensor.all_round) outline.push_back(at);
    for (const Vector2d& direction : sensor.field)
      outline.emplace_back(at + radius * Vector2d(-direction.y(), -direction.x()));
    chart_.path(outline);
    chart_.close();
    chart_.stroke(color, 1.4);
    chart_.circle(at, 4);
    chart_.fill(color);
    if (sensor.all_round)
      return chart_.label(at - Vector2d(0, radius + 5), sensor.name, 13, color, Align::middle);
    // Names stand beside the vehicle, on the sensor's side.
    const bool left = sensor.at.y() > 0.05 || (std::abs(sensor.at.y()) <= 0.05 && index % 2 == 1);
    const Vector2d place = at + Vector2d(left ? -radius - 6 : radius + 6, sensor.at.x() < -0.5 ? 14 : -6);
    chart_.label(place, sensor.name, 13, color, left ? Align::right : Align::left);
  }
  void scale_bar() {
    const double length = round_step(shown(), 5);
    const double pixels = length * chart_.pixels_per_meter();
    const double x = field_left + 16;
    const double y = field_top + field_height - 16;
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
    group("MERGED SCANS", Role::merged);
    group("VIRTUAL SCANS", Role::virtual_scan);
    if (!view_.free_note.empty()) {
      legend_text("AREAS", 12, pale);
      legend_y_ += 6;
      legend_area("free", view_.free_note, true);
      legend_area("unknown", view_.unobserved_note, false);
      legend_y_ += 8;
    }
    legend_text(
        "White: nothing is said. Around each sensor: its field of view. Ahead is up; rings are metres "
        "around " +
            view_.base_frame + ".",
        12, pale, 0, false);
    legend_y_ += 8;
    for (const auto& sentence : view_.missing) legend_text(sentence, 12, {0.70, 0.20, 0.00});
  }
  void legend_layer(const SnapshotView::Layer& layer) {
    const Color color = color_of(layer.role, layer.number);
    const double y = legend_y_ - 5;
    if (layer.role == Role::input || layer.role == Role::cloud) {
      for (const double x : {4.0, 14.0, 24.0}) chart_.dot({legend_left + x, y});
      chart_.stroke(color, layer.role == Role::input ? 6 : 2);
    } else {
      chart_.path({{legend_left, y}, {legend_left + 28, y}});
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
    chart_.rectangle(legend_left, legend_y_ - 13, 28, 18);
    chart_.fill(observed ? free_color : unobserved_color);
    chart_.rectangle(legend_left, legend_y_ - 13, 28, 18);
    if (!observed) chart_.hatch(hatch_color, 7);
    chart_.rectangle(legend_left, legend_y_ - 13, 28, 18);
    chart_.stroke({0.6, 0.6, 0.6}, 0.8);
    legend_entry(name, note);
  }
  /// Writes words into the legend, in as many lines as they need.
  void legend_text(const std::string& words, double size, const Color& color, double indent = 0,
                   bool bold = false) {
    std::string row;
    const auto put = [&] {
      if (row.empty()) return;
      chart_.text({legend_left + indent, legend_y_}, row, size, color, Align::left, bold);
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
      text += "\nfree: " + view_.free_note + "\nunknown: " + view_.unobserved_note;
    for (const auto& sentence : view_.missing) text += "\n" + sentence;
    return text;
  }

  const SnapshotView& view_;
  Chart chart_;
  double legend_y_ = 0;
};

}  // namespace

std::string draw_snapshot(const SnapshotView& view, PictureFormat format) {
  return Painter(view, format).paint();
}

}  // namespace lidard
