// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cairo-svg.h>
#include <cairo.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/angle.h"
#include "daemon/files/snapshot_view.h"

namespace lidard {

struct Color {
  double red, green, blue;
  double alpha = 1;
};

/// The colour of a value between the ends of a scale, 0 ... 1: the map viridis of matplotlib (CC0), whose
/// steps appear equal and differ in brightness for people with any colour vision; without its end, too bright
/// on white.
inline Color scale_color(double share) {
  constexpr Color steps[] = {{0.267, 0.005, 0.329}, {0.278, 0.173, 0.478}, {0.231, 0.318, 0.545},
                             {0.173, 0.443, 0.557}, {0.129, 0.565, 0.553}, {0.153, 0.678, 0.506},
                             {0.361, 0.784, 0.388}, {0.667, 0.863, 0.196}};
  const double at = std::clamp(share, 0.0, 1.0) * (std::size(steps) - 1);
  const auto low = std::min(static_cast<std::size_t>(at), std::size(steps) - 2);
  const double part = at - static_cast<double>(low);
  const Color &from = steps[low], &to = steps[low + 1];
  const auto mix = [&](double a, double b) { return a * (1 - part) + b * part; };
  return {mix(from.red, to.red), mix(from.green, to.green), mix(from.blue, to.blue)};
}

/// A page to draw on, in pixels from its upper left corner. Coordinates in `meters` are in base_frame, whose
/// x axis points up.
class Chart {
 public:
  Chart(PictureFormat format, double width, double height) : format_(format) {
    if (format == PictureFormat::svg) {
      surface_ = cairo_svg_surface_create_for_stream(append, &bytes_, width, height);
      cairo_svg_surface_set_document_unit(surface_, CAIRO_SVG_UNIT_PX);
    } else {
      surface_ =
          cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width), static_cast<int>(height));
    }
    pen_ = cairo_create(surface_);
    rectangle(0, 0, width, height);
    fill({1, 1, 1});
  }
  ~Chart() {
    cairo_destroy(pen_);
    cairo_surface_destroy(surface_);
  }
  Chart(const Chart&) = delete;
  Chart& operator=(const Chart&) = delete;

  /// Sets the part of the page for measurements, and the area of base_frame in it. `half` is the least extent
  /// from the center, ahead and to the left.
  void set_field(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const Eigen::Vector2d& center,
                 const Eigen::Vector2d& half) {
    corner_ = corner;
    size_ = size;
    center_ = center;
    scale_ = std::min(size.x() / (2 * half.y()), size.y() / (2 * half.x()));
  }
  /// Moves all that is drawn from now on to the right, beside what was drawn.
  void shift(double pixels) {
    cairo_translate(pen_, pixels, 0);
    labels_.clear();
    marks_.clear();
  }
  double pixels_per_meter() const { return scale_; }
  Eigen::Vector2d to_page(const Eigen::Vector2d& meters) const {
    const Eigen::Vector2d from_center = meters - center_;
    return {tenth(corner_.x() + size_.x() / 2 - from_center.y() * scale_),
            tenth(corner_.y() + size_.y() / 2 - from_center.x() * scale_)};
  }
  Eigen::Vector2d to_page(const Eigen::Vector2f& meters) const {
    return to_page(Eigen::Vector2d(meters.cast<double>()));
  }
  /// True if a position on the page lies in the field.
  bool shows(const Eigen::Vector2d& p) const {
    return Eigen::AlignedBox2d(corner_, corner_ + size_).contains(p);
  }
  /// A colour for a position on the page.
  struct Dot {
    Eigen::Vector2d at;
    Color color;
  };
  /// Draws dots into the field, each `side` pixels wide, as pixels in an SVG too: shapes would make the file
  /// too large to open.
  void dots(const std::vector<Dot>& dots, int side, double opacity) {
    const auto width = static_cast<int>(std::lround(size_.x())),
               height = static_cast<int>(std::lround(size_.y()));
    cairo_surface_t* image = cairo_image_surface_create(CAIRO_FORMAT_ARGB32, width, height);
    unsigned char* data = cairo_image_surface_get_data(image);
    const int stride = cairo_image_surface_get_stride(image);
    const auto byte = [](double share) { return static_cast<std::uint32_t>(std::lround(255 * share)); };
    for (const Dot& dot : dots) {
      const Eigen::Vector2d p = dot.at - corner_;
      if (!(p.x() >= 0 && p.y() >= 0 && p.x() < width && p.y() < height)) continue;
      mark(dot.at);
      const Color& c = dot.color;
      const std::uint32_t pixel = 0xff000000U | byte(c.red) << 16U | byte(c.green) << 8U | byte(c.blue);
      for (int y = static_cast<int>(p.y()); y < std::min(height, static_cast<int>(p.y()) + side); ++y) {
        auto* row = reinterpret_cast<std::uint32_t*>(data + std::ptrdiff_t{y} * stride);
        for (int x = static_cast<int>(p.x()); x < std::min(width, static_cast<int>(p.x()) + side); ++x)
          row[x] = pixel;
      }
    }
    cairo_surface_mark_dirty(image);
    cairo_set_source_surface(pen_, image, corner_.x(), corner_.y());
    cairo_paint_with_alpha(pen_, opacity);
    cairo_surface_destroy(image);
  }

  /// Clips drawings at the field until end_clip().
  void begin_clip() {
    cairo_save(pen_);
    rectangle(corner_.x(), corner_.y(), size_.x(), size_.y());
    cairo_clip(pen_);
  }
  void end_clip() { cairo_restore(pen_); }

  void rectangle(double x, double y, double width, double height) {
    cairo_rectangle(pen_, x, y, width, height);
  }
  /// Points and lines from now on occupy their positions for label_where_free().
  void begin_marks() { marks_.assign(static_cast<std::size_t>(columns() * (size_.y() / mark_size + 1)), 0); }

  void move_to(const Eigen::Vector2d& p) {
    cairo_move_to(pen_, p.x(), p.y());
    mark(p);
  }
  void line_to(const Eigen::Vector2d& p) {
    Eigen::Vector2d from = p;
    if (cairo_has_current_point(pen_) != 0) cairo_get_current_point(pen_, &from.x(), &from.y());
    cairo_line_to(pen_, p.x(), p.y());
    const double parts = marks_.empty() ? 0 : std::ceil((p - from).norm() / mark_size);
    for (double part = 1; part <= parts; ++part) mark(from + (p - from) * (part / parts));
  }
  void close() { cairo_close_path(pen_); }
  /// A path through points.
  template <class Points>
  void path(const Points& points) {
    bool begins = true;
    for (const Eigen::Vector2d& p : points) {
      if (begins)
        move_to(p);
      else
        line_to(p);
      begins = false;
    }
  }
  void path(std::initializer_list<Eigen::Vector2d> points) { path<>(points); }
  /// A round dot once the path is stroked.
  void dot(const Eigen::Vector2d& p) {
    move_to(p);
    line_to(p);
  }
  void circle(const Eigen::Vector2d& center, double radius) {
    cairo_new_sub_path(pen_);
    cairo_arc(pen_, center.x(), center.y(), radius, 0, two_pi);
  }
  /// Lines without grey edges until end_crisp(): such edges would be most of a picture's bytes.
  void begin_crisp() { cairo_set_antialias(pen_, CAIRO_ANTIALIAS_NONE); }
  void end_crisp() { cairo_set_antialias(pen_, CAIRO_ANTIALIAS_DEFAULT); }
  void fill(const Color& color) {
    set_source(pen_, color);
    cairo_fill(pen_);
  }
  void stroke(const Color& color, double width, const std::vector<double>& dashes = {}) {
    set_source(pen_, color);
    cairo_set_line_width(pen_, width);
    cairo_set_line_cap(pen_, CAIRO_LINE_CAP_ROUND);
    cairo_set_line_join(pen_, CAIRO_LINE_JOIN_ROUND);
    cairo_set_dash(pen_, dashes.data(), static_cast<int>(dashes.size()), 0);
    cairo_stroke(pen_);
    cairo_set_dash(pen_, nullptr, 0, 0);
  }
  enum class Align { left, middle, right };
  /// Text whose baseline stands at `p`.
  void text(const Eigen::Vector2d& p, const std::string& words, double size, const Color& color,
            Align align = Align::left, bool bold = false) {
    const double width = text_width(words, size, bold);
    const double shift = align == Align::left ? 0 : align == Align::middle ? width / 2 : width;
    set_source(pen_, color);
    cairo_move_to(pen_, tenth(p.x() - shift), tenth(p.y()));
    cairo_show_text(pen_, words.c_str());
    cairo_new_path(pen_);
  }
  /// text() with a white edge, to be readable on any background; moved into the field, and up or down to a
  /// position without a label.
  void label(Eigen::Vector2d p, const std::string& words, double size, const Color& color,
             Align align = Align::left) {
    const double width = text_width(words, size), wanted = p.y();
    p.x() -= align == Align::left ? 0 : width;
    p.x() = std::max(corner_.x() + 3, std::min(p.x(), corner_.x() + size_.x() - width - 3));
    const auto box = [&] {
      return Eigen::AlignedBox2d(p - Eigen::Vector2d(2, size), p + Eigen::Vector2d(width + 2, 3));
    };
    const auto is_free = [&] {
      return shows(p) && shows(p - Eigen::Vector2d(0, size)) &&
             std::none_of(labels_.begin(), labels_.end(),
                          [&](const Eigen::AlignedBox2d& other) { return other.intersects(box()); });
    };
    constexpr int most_steps = 40;
    for (int n = 0; n < most_steps && !is_free(); ++n) {
      const int half_lines = n / 2 + 1;
      p.y() = wanted + (n % 2 == 0 ? half_lines : -half_lines) * size / 2;
    }
    edged_text(p, words, size, color, box());
  }
  /// text() with a white edge around the first of `positions` where nothing stands, else where the least
  /// does, but not on another label; nothing if no position of the field remains.
  void label_where_free(const std::vector<Eigen::Vector2d>& positions, const std::string& words, double size,
                        const Color& color) {
    const Eigen::AlignedBox2d field(corner_, corner_ + size_);
    const Eigen::Vector2d half(text_width(words, size) / 2 + 4, size / 2 + 3);
    std::optional<Eigen::AlignedBox2d> best;
    std::size_t fewest = 0;
    for (const Eigen::Vector2d& position : positions) {
      const Eigen::AlignedBox2d box(position - half, position + half);
      const bool is_taken = std::any_of(labels_.begin(), labels_.end(),
                                        [&](const auto& other) { return other.intersects(box); });
      if (is_taken || !field.contains(box)) continue;
      const std::size_t count = marks_in(box);
      if (best && count >= fewest) continue;
      best = box, fewest = count;
      if (count == 0) break;
    }
    if (best)
      edged_text(best->corner(Eigen::AlignedBox2d::TopLeft) + Eigen::Vector2d(4, -5), words, size, color,
                 *best);
  }
  double text_width(const std::string& words, double size, bool bold = false) {
    set_font(size, bold);
    cairo_text_extents_t extents;
    cairo_text_extents(pen_, words.c_str(), &extents);
    return extents.x_advance;
  }

  /// The finished file. `description` goes into an SVG as text that programs can read.
  std::string bytes(const std::string& title, const std::string& description) {
    cairo_status_t status = cairo_status(pen_);
    if (format_ == PictureFormat::png) status = cairo_surface_write_to_png_stream(surface_, append, &bytes_);
    cairo_surface_finish(surface_);
    if (status == CAIRO_STATUS_SUCCESS) status = cairo_surface_status(surface_);
    if (status != CAIRO_STATUS_SUCCESS)
      throw std::runtime_error(std::string("the picture could not be drawn: ") +
                               cairo_status_to_string(status));
    if (format_ == PictureFormat::png) return bytes_;
    const std::size_t inside = bytes_.find('>', bytes_.find("<svg")) + 1;
    return bytes_.substr(0, inside) + "\n<title>" + escaped(title) + "</title>\n<desc>" +
           escaped(description) + "</desc>" + bytes_.substr(inside);
  }

 private:
  static constexpr double mark_size = 2;  // pixels
  double columns() const { return std::floor(size_.x() / mark_size) + 1; }
  std::size_t index_of_mark(const Eigen::Vector2d& p) const {
    const Eigen::Array2d at = ((p - corner_) / mark_size).array().floor();
    return static_cast<std::size_t>(at.y() * columns() + at.x());
  }
  void mark(const Eigen::Vector2d& p) {
    if (!marks_.empty() && shows(p)) marks_[index_of_mark(p)] = 1;
  }
  /// `box` lies in the field.
  std::size_t marks_in(const Eigen::AlignedBox2d& box) const {
    std::size_t count = 0;
    for (Eigen::Vector2d p = box.min(); p.y() <= box.max().y(); p.y() += mark_size) {
      for (p.x() = box.min().x(); p.x() <= box.max().x(); p.x() += mark_size)
        count += static_cast<std::size_t>(marks_[index_of_mark(p)]);
    }
    return count;
  }
  /// `box`: where no other label may stand.
  void edged_text(const Eigen::Vector2d& p, const std::string& words, double size, const Color& color,
                  const Eigen::AlignedBox2d& box) {
    labels_.push_back(box);
    cairo_move_to(pen_, tenth(p.x()), tenth(p.y()));
    cairo_text_path(pen_, words.c_str());
    stroke({1, 1, 1, 0.85}, 3);
    text(p, words, size, color);
  }
  static cairo_status_t append(void* bytes, const unsigned char* data, unsigned int length) {
    static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
    return CAIRO_STATUS_SUCCESS;
  }
  /// A tenth of a pixel is enough, and keeps an SVG short.
  static double tenth(double pixels) { return std::round(pixels * 10) / 10; }
  static void set_source(cairo_t* pen, const Color& c) {
    cairo_set_source_rgba(pen, c.red, c.green, c.blue, c.alpha);
  }
  static std::string escaped(const std::string& text) {
    std::string out;
    for (const char c : text) {
      if (c == '&')
        out += "&amp;";
      else if (c == '<')
        out += "&lt;";
      else
        out += c;
    }
    return out;
  }
  void set_font(double size, bool bold) {
    cairo_select_font_face(pen_, "DejaVu Sans", CAIRO_FONT_SLANT_NORMAL,
                           bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(pen_, size);
  }

  PictureFormat format_;
  std::string bytes_;
  cairo_surface_t* surface_;
  cairo_t* pen_;
  Eigen::Vector2d corner_{0, 0};
  Eigen::Vector2d size_{1, 1};
  double scale_ = 1;
  Eigen::Vector2d center_{0, 0};
  std::vector<Eigen::AlignedBox2d> labels_;  // where they stand on the page
  std::vector<char> marks_;  // by rows of the field: something is drawn there; empty: not kept
};

}  // namespace lidard
