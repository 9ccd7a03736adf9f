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

TEST_F(Pictures, HaveTheLabelsOfRingsWhereNothingIsDrawn) {
  // A cloud along one of the diagonals ahead, which are mirror images.
  const auto picture_with = [&](float side, double& labels) {
    SnapshotView view = empty_view();
    SnapshotView::Layer cloud{Role::cloud, 0, "roof/points", "cloud", {}, {}, {}};
    for (float r = 0.5F; r < 8; r += 0.02F) {
      for (float across = -0.5F; across <= 0.5F; across += 0.1F)
        cloud.points.emplace_back(0.75F * r - across, side * (0.65F * r + across));
    }
    cloud.values.assign(cloud.points.size(), 0);
    view.layers.push_back(cloud);
    const Pixels picture = pixels_of(view);
    const auto is_label = [](auto p) { return is_like(p, {115, 115, 115}, 40); };
    labels = static_cast<double>(find(picture, 90, picture.height - 10, is_label).count);
    return find(picture, 76, picture.height, [](auto p) { return is_like(p, {68, 1, 84}, 10); }).count;
  };
  double labels = 0, labels_elsewhere = 0;
  const auto right = static_cast<double>(picture_with(-1, labels));
  const auto left = static_cast<double>(picture_with(1, labels_elsewhere));
  EXPECT_GT(right, 1000);
  EXPECT_GT(right, 0.97 * left) << "labels, which prefer the right, cover nothing there";
  EXPECT_GT(labels, 30);
  EXPECT_GT(labels_elsewhere, 30);
}

TEST_F(Pictures, HaveAFewRings) {
  struct Case {
    double half;
    int width;
    const char* gap;
  };
  for (const Case& one :
       {Case{6, 560, "2 m"}, Case{14, 660, "5 m"}, Case{12, 800, "5 m"}, Case{14, 1200, "5 m"},
        Case{2, 0, "0.5 m"}, Case{100, 0, "20 m"}, Case{100, 560, "50 m"}}) {
    SnapshotView view = empty_view();
    view.framing.half = {one.half, one.half};
    view.framing.width = one.width;
    EXPECT_THAT(draw_snapshot({view}, PictureFormat::svg),
                HasSubstr(std::string("Rings: every ") + one.gap + " from base_link."))
        << one.half << " m in " << one.width;
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
