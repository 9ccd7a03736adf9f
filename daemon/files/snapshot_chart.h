// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <initializer_list>
#include <string>
#include <vector>

struct _cairo;
struct _cairo_surface;

namespace lidard {

struct Color {
  double red, green, blue;
  double alpha = 1;
};

/// A page to draw on, in pixels from its upper left corner. What is drawn in `meters` stands on a part of
/// base_frame whose x axis points up.
class Chart {
 public:
  enum class Format { png, svg };

  Chart(Format format, double width, double height);
  ~Chart();
  Chart(const Chart&) = delete;
  Chart& operator=(const Chart&) = delete;

  /// The part of the page for what is measured, and what of base_frame it shows.
  /// `half` is how far it shows at least from the center, ahead and to the left.
  void set_field(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, const Eigen::Vector2d& center,
                 const Eigen::Vector2d& half);
  double pixels_per_meter() const { return scale_; }
  Eigen::Vector2d to_page(const Eigen::Vector2d& meters) const;
  Eigen::Vector2d to_page(const Eigen::Vector2f& meters) const;
  /// Keeps what is drawn until end_clip() inside the field.
  void begin_clip();
  void end_clip();

  void rectangle(double x, double y, double width, double height);
  void move_to(const Eigen::Vector2d& p);
  void line_to(const Eigen::Vector2d& p);
  void close();
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
  void dot(const Eigen::Vector2d& p);
  void circle(const Eigen::Vector2d& center, double radius);
  void fill(const Color& color);
  void stroke(const Color& color, double width, const std::vector<double>& dashes = {});
  /// Fills the path with slanting lines.
  void hatch(const Color& color, double distance);

  enum class Align { left, middle, right };
  /// Text whose baseline stands at `p`.
  void text(const Eigen::Vector2d& p, const std::string& words, double size, const Color& color,
            Align align = Align::left, bool bold = false);
  /// text() with a white edge, to be readable on whatever is below.
  void label(const Eigen::Vector2d& p, const std::string& words, double size, const Color& color,
             Align align = Align::left);
  double text_width(const std::string& words, double size, bool bold = false);

  /// The finished file. `description` goes into an SVG as text that programs can read.
  std::string bytes(const std::string& title, const std::string& description);

 private:
  void set_font(double size, bool bold);

  Format format_;
  std::string bytes_;
  _cairo_surface* surface_;
  _cairo* pen_;
  Eigen::Vector2d corner_{0, 0};
  Eigen::Vector2d size_{1, 1};
  double scale_ = 1;
  Eigen::Vector2d center_{0, 0};
};

}  // namespace lidard
