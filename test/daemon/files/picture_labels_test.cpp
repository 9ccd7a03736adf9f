// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Names in pictures are whole and do not cover each other, and the legend says what the colours mean.
#include "test/daemon/files/pictures_support.h"

namespace lidard::test {
namespace {

/// A picture 560 wide of 12 m around a vehicle, without returns.
SnapshotView empty_view() {
  SnapshotView view;
  view.base_frame = "base_link";
  view.framing.half = {6, 6};
  view.framing.width = 560;
  return view;
}

/// Colours of roles as the style has them.
constexpr Rgb blue{0, 115, 179}, orange{214, 94, 0}, red{214, 0, 115}, violet{115, 51, 140};

TEST_F(Pictures, HaveTheWholeNameOfASensorAtTheirEdge) {
  const auto letters = [&](double left) {
    SnapshotView view = empty_view();
    view.sensors.push_back({"front_right", {0, left}, {}, false, Role::input, 0});
    const Pixels picture = pixels_of(view);
    return find(picture, 76, picture.height, [](auto p) { return is_like(p, blue, 70); }).count;
  };
  const std::size_t whole = letters(0);
  ASSERT_GT(whole, 150U);
  for (const double left : {-3.5, -4.5, -5.5, 4.5, 5.5})
    EXPECT_NEAR(static_cast<double>(letters(left)), static_cast<double>(whole),
                0.1 * static_cast<double>(whole))
        << left << " m to the left";
}

TEST_F(Pictures, HaveNoNameOfASensorUponAnother) {
  const auto letters = [&](bool alone) {
    SnapshotView view = empty_view();
    view.sensors.push_back({"front_right", {0, -1.0}, {}, false, Role::input, 0});
    if (!alone) view.sensors.push_back({"front_radar", {0.5, -1.0}, {}, false, Role::input, 1});
    const Pixels picture = pixels_of(view);
    return find(picture, 76, picture.height, [](auto p) { return is_like(p, blue, 70); }).count;
  };
  EXPECT_NEAR(static_cast<double>(letters(false)), static_cast<double>(letters(true)), 5);
}

TEST_F(Pictures, NameEveryPlaneOfTheSideView) {
  using Plane = SnapshotView::Plane;
  const std::vector<std::pair<Plane, Rgb>> all{
      {{Role::input, 0, "front_left/scan", {0, 0.35}, {1, 0}}, blue},
      {{Role::input, 1, "front_right/scan", {0, 0.35}, {1, 0}}, orange},
      {{Role::virtual_scan, 0, "the_bumper_of_it", {0.1, 0.3}, {1, 0}}, red},
      {{Role::virtual_scan, 1, "the_chest_of_it", {0.1, 1.2}, {1, 0}}, violet}};
  const auto draw_planes = [&](const std::vector<Plane>& planes) {
    SnapshotView view = empty_view();
    view.planes = planes;
    view.lidars.push_back({0, 2});
    view.framing.low = -0.5, view.framing.high = 2.5;
    return pixels_of(view);
  };
  std::vector<Plane> planes;
  for (const auto& [plane, color] : all) planes.push_back(plane);
  const Pixels together = draw_planes(planes);
  for (const auto& [plane, color] : all) {
    // Lines lie upon each other: only pixels beside them are letters'.
    const auto letters = [&, &color = color](const Pixels& picture) {
      std::size_t count = 0;
      for (int y = 330; y < picture.height; ++y) {
        const auto in_row = [&](int row) {
          return find(picture, row, row + 1, [&](auto p) { return is_like(p, color, 60); }).count;
        };
        count += in_row(y) < 90 ? in_row(y) : 0;
      }
      return static_cast<double>(count);
    };
    const double alone = letters(draw_planes({plane}));
    ASSERT_GT(alone, 100) << plane.name;
    EXPECT_NEAR(letters(together), alone, 0.15 * alone) << plane.name;
  }
}

TEST_F(Pictures, SayWhatWhiteMeansWhereAreasAreShaded) {
  SnapshotOptions options = of_demo();
  options.output = path("x.svg");
  ASSERT_EQ(draw(options), exit_ok) << said;
  EXPECT_THAT(content("x.svg"),
              AllOf(HasSubstr("White: unknown too: behind what was hit"), Not(HasSubstr("nothing is said"))));
  options.areas = "bumper";
  ASSERT_EQ(draw(options), exit_ok) << said;
  EXPECT_THAT(content("x.svg"), Not(HasSubstr("White:")));
}

}  // namespace
}  // namespace lidard::test
