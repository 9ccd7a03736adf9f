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

/// The colour of the first scanner.
constexpr Rgb blue{0, 115, 179};

TEST_F(Pictures, HaveTheWholeNameOfASensorAtTheirEdge) {
  const auto letters = [&](double left) {
    SnapshotView view = empty_view();
    view.sensors.push_back({"front_right", {0, left}, Role::input, 0});
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
    view.sensors.push_back({"front_right", {0, -1.0}, Role::input, 0});
    if (!alone) view.sensors.push_back({"front_radar", {0.5, -1.0}, Role::input, 1});
    const Pixels picture = pixels_of(view);
    return find(picture, 76, picture.height, [](auto p) { return is_like(p, blue, 70); }).count;
  };
  EXPECT_NEAR(static_cast<double>(letters(false)), static_cast<double>(letters(true)), 5);
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
