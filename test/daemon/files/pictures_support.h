// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Reads pictures back, and finds in them what was drawn.
#pragma once

#include <cairo/cairo.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/commands/commands.h"
#include "daemon/files/snapshot_view.h"
#include "daemon/offline/survey.h"
#include "test/support/captures.h"

namespace lidard::test {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Role = SnapshotView::Role;

/// Pixels at the right of a picture that are the legend's.
constexpr int legend = 300;

/// A picture as rows of 0xRRGGBB.
struct Pixels {
  int width = 0, height = 0;
  std::vector<std::uint32_t> rgb;
};

inline Pixels read_png(const std::string& path) {
  Pixels out;
  cairo_surface_t* image = cairo_image_surface_create_from_png(path.c_str());
  if (cairo_surface_status(image) == CAIRO_STATUS_SUCCESS) {
    out.width = cairo_image_surface_get_width(image);
    out.height = cairo_image_surface_get_height(image);
    const unsigned char* data = cairo_image_surface_get_data(image);
    for (int y = 0; y < out.height; ++y) {
      const auto* row =
          reinterpret_cast<const std::uint32_t*>(data + y * cairo_image_surface_get_stride(image));
      for (int x = 0; x < out.width; ++x) out.rgb.push_back(row[x] & 0xffffffU);
    }
  }
  cairo_surface_destroy(image);
  return out;
}

struct Rgb {
  int red, green, blue;
};
inline Rgb parts(std::uint32_t pixel) {
  return {static_cast<int>(pixel >> 16U & 255U), static_cast<int>(pixel >> 8U & 255U),
          static_cast<int>(pixel & 255U)};
}
/// True for the colours of returns: those of areas and lines are pale.
inline bool is_colorful(std::uint32_t pixel) {
  const Rgb c = parts(pixel);
  return std::max({c.red, c.green, c.blue}) - std::min({c.red, c.green, c.blue}) > 60;
}
inline bool is_like(std::uint32_t pixel, const Rgb& color, int tolerance) {
  const Rgb c = parts(pixel);
  return std::abs(c.red - color.red) <= tolerance && std::abs(c.green - color.green) <= tolerance &&
         std::abs(c.blue - color.blue) <= tolerance;
}

/// The number of pixels left of the legend that pass, and their middle.
struct Found {
  std::size_t count = 0;
  double x = 0, y = 0;
};
template <class Passes>
Found find(const Pixels& picture, int top, int bottom, Passes passes) {
  Found found;
  for (int y = top; y < std::min(bottom, picture.height); ++y) {
    for (int x = 0; x < picture.width - legend; ++x) {
      if (!passes(picture.rgb[static_cast<std::size_t>(y * picture.width + x)])) continue;
      ++found.count;
      found.x += x;
      found.y += y;
    }
  }
  if (found.count > 0)
    found.x /= static_cast<double>(found.count), found.y /= static_cast<double>(found.count);
  return found;
}

class Pictures : public ::testing::Test {
 protected:
  Pictures() { fs::create_directories(folder_); }
  ~Pictures() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return folder_ + "/" + name; }
  /// Returns the exit code; the messages are in `said`.
  int draw(SnapshotOptions options) {
    std::ostringstream err;
    const int code = run_snapshot(options, err);
    said = err.str();
    return code;
  }
  static SnapshotOptions of_demo() {
    SnapshotOptions options;
    options.config = project_file("config/demo.yaml");
    options.captures = {project_file("pcaps/demo.pcap")};
    return options;
  }
  Pixels pixels_of(const SnapshotView& view) const {
    std::ofstream(path("view.png"), std::ios::binary) << draw_snapshot({view}, PictureFormat::png);
    return read_png(path("view.png"));
  }
  std::string content(const std::string& name) const { return test::content(path(name)); }
  /// Each capture below a folder gives a picture with colours in it or, where `some_hold_nothing`, a reason.
  void expect_pictures(const std::string& below, bool some_hold_nothing) {
    std::size_t drawn = 0;
    for (const auto& entry : fs::recursive_directory_iterator(below)) {
      const std::string file = entry.path();
      const std::string end = entry.path().extension();
      if (end != ".pcap" && end != ".pcapng") continue;
      SnapshotOptions options;
      options.captures = {file};
      options.output = path("x.png");
      fs::remove(options.output);
      const int code = draw(options);
      if (code == exit_ok) {
        ++drawn;
        const Pixels picture = read_png(options.output);
        EXPECT_GT(find(picture, 0, picture.height, is_colorful).count, 800U) << file;
      } else {
        EXPECT_EQ(code, exit_failed) << file;
        const bool holds_nothing =
            file.find("radar") != std::string::npos || file.find("position_only") != std::string::npos;
        EXPECT_TRUE(some_hold_nothing || holds_nothing) << file << ": " << said;
        EXPECT_THAT(said, HasSubstr(file)) << "the reason names the capture";
        EXPECT_FALSE(fs::exists(options.output)) << file;
        EXPECT_TRUE(survey({file}).sensors.empty()) << file << " holds a sensor";
      }
    }
    EXPECT_GT(drawn, 1U) << below;
  }

  std::string said;

 private:
  const std::string folder_ = ::testing::TempDir() + "lidard-pictures-" + std::to_string(getpid());
};

}  // namespace lidard::test
