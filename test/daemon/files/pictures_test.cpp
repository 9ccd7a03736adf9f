// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Pictures of captures: each shows what was measured, where it was measured, or there is none and a reason.
#include "test/daemon/files/pictures_support.h"

namespace lidard::test {
namespace {

TEST_F(Pictures, OfEveryCaptureOfTheProjectShowWhatWasMeasured) {
  expect_pictures(project_file("pcaps"), false);
}

TEST_F(Pictures, OfEveryRealCaptureShowWhatWasMeasured) {
  LIDARD_NEED_CAPTURE(velodyne, "velodyne/vlp16_strongest_84.pcap");
  const fs::path all = fs::path(velodyne).parent_path().parent_path();
  expect_pictures(all / "velodyne", false);
  expect_pictures(all / "sick", false);
  expect_pictures(all / "burst", false);
  expect_pictures(all / "odd", true);
}

TEST_F(Pictures, OfASensorWithoutItsCalibrationWarnAsDecodeDoes) {
  LIDARD_NEED_CAPTURE(capture, "velodyne/hdl64e_s1_atwall_306.pcap");
  DecodeOptions decode;
  decode.capture = capture;
  decode.output = path("x.csv");
  std::ostringstream decoded;
  run_decode(decode, decoded);
  const std::string warning = "calibration";
  EXPECT_THAT(decoded.str(), HasSubstr(warning));
  SnapshotOptions options;
  options.captures = {capture};
  options.output = path("x.png");
  EXPECT_EQ(draw(options), exit_ok) << said;
  EXPECT_THAT(said, HasSubstr(warning));
}

TEST_F(Pictures, OfAPartOfATurnShowItAndSaySo) {
  // 0.1 s of a VLP-16 at 10 Hz has a turn; the first third of it has none.
  std::string bytes = test::content(project_file("pcaps/vlp16_last.pcap"));
  constexpr std::size_t header = 24, record = 16 + 42 + 1206;
  bytes.resize(header + 25 * record);
  std::ofstream(path("part.pcap"), std::ios::binary) << bytes;
  SnapshotOptions options;
  options.captures = {path("part.pcap")};
  options.output = path("part.svg");
  ASSERT_EQ(draw(options), exit_ok) << said;
  EXPECT_THAT(content("part.svg"), AllOf(HasSubstr("of a frame"), HasSubstr("What there is of it is drawn")));
  options.output = path("part.png");
  ASSERT_EQ(draw(options), exit_ok) << said;
  const Pixels picture = read_png(options.output);
  EXPECT_GT(find(picture, 0, picture.height, is_colorful).count, 800U);
}

TEST_F(Pictures, WithoutAConfigurationShowEverySensorAndSayWhereTheyStand) {
  SnapshotOptions options;
  options.captures = {project_file("pcaps/demo.pcap")};
  options.output = path("x.svg");
  ASSERT_EQ(draw(options), exit_ok) << said;
  EXPECT_THAT(content("x.svg"),
              AllOf(HasSubstr("sick_microscan3/scan"), HasSubstr("sick_microscan3_2/scan"),
                    HasSubstr("velodyne_vlp16/points"), HasSubstr("All sensors stand at the origin"),
                    HasSubstr("`lidard inspect` prints one to edit"), Not(HasSubstr("free:"))));
}

TEST_F(Pictures, OfTheConfigurationThatInspectPrintsAreNotEmpty) {
  std::ostringstream out, err;
  ASSERT_EQ(run_inspect({project_file("pcaps/vlp32c.pcap")}, false, out, err), exit_ok);
  EXPECT_THAT(out.str(), HasSubstr("pose: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}  # edit"));
  std::ofstream(path("v.yaml")) << out.str();
  SnapshotOptions options;
  options.config = path("v.yaml");
  options.captures = {project_file("pcaps/vlp32c.pcap")};
  options.output = path("x.png");
  ASSERT_EQ(draw(options), exit_ok) << said;
  const Pixels picture = read_png(options.output);
  EXPECT_GT(find(picture, 0, picture.height, is_colorful).count, 5000U);
}

TEST_F(Pictures, ThatWouldBeEmptyAreAnErrorWithTheReason) {
  std::ofstream(path("v.yaml")) << "sensors: {roof: {model: velodyne_vlp32c}}\n";  // no pose
  SnapshotOptions options;
  options.config = path("v.yaml");
  options.captures = {project_file("pcaps/vlp32c.pcap")};
  options.output = path("x.png");
  EXPECT_EQ(draw(options), exit_failed);
  EXPECT_THAT(said, AllOf(HasSubstr("there is nothing to draw: "), HasSubstr("roof is not drawn")));
  EXPECT_FALSE(fs::exists(options.output));
}

/// Two clumps of returns: a low one ahead to the left, a high one ahead to the right.
SnapshotView two_clumps() {
  SnapshotView view;
  view.base_frame = "base_link";
  SnapshotView::Layer cloud{Role::cloud, 0, "roof/points", "cloud", {}, {}, {}};
  for (int i = 0; i < 400; ++i) {
    const float spread = 0.001F * static_cast<float>(i);
    cloud.points.emplace_back(4 + spread, 3 + spread);
    cloud.values.push_back(0);
    cloud.points.emplace_back(4 + spread, -3 - spread);
    cloud.values.push_back(2);
  }
  cloud.scale = {0, 2};
  view.layers.push_back(cloud);
  view.framing.center = {0, 0};
  view.framing.half = {6, 6};
  return view;
}

// The ends of the colours: matplotlib's viridis at 0 and 0.875.
constexpr Rgb low_color{68, 1, 84}, high_color{170, 220, 50};

TEST_F(Pictures, PutReturnsWhereTheyAreInTheColourOfTheirHeight) {
  const SnapshotView view = two_clumps();
  const Pixels picture = pixels_of(view);
  const double side = std::sqrt(760'000.0);  // of the field, which is a square here
  const int middle = 76 + static_cast<int>(side / 2);
  const auto low = find(picture, 76, middle, [](auto p) { return is_like(p, low_color, 25); });
  const auto high = find(picture, 76, middle, [](auto p) { return is_like(p, high_color, 25); });
  ASSERT_GT(low.count, 50U);
  ASSERT_GT(high.count, 50U);
  // Ahead is up, left is left; 6 m are half the field.
  const double meter = side / 12;
  EXPECT_NEAR(low.x, 20 + side / 2 - 3.2 * meter, 4);
  EXPECT_NEAR(high.x, 20 + side / 2 + 3.2 * meter, 8);
  EXPECT_NEAR(low.y, 76 + side / 2 - 4.2 * meter, 4);
}

TEST_F(Pictures, AreFramedByTheReturnsAndNotByTheFewFarOff) {
  SnapshotView view;
  SnapshotView::Layer cloud{Role::cloud, 0, "roof/points", "cloud", {}, {}, {}};
  std::size_t inside = 0;
  for (int i = 0; i < 1000; ++i) {
    // A street to the left and right: 60 m wide, 10 m deep; every fiftieth return is far off.
    const bool far = i % 50 == 0;
    const auto along = static_cast<float>(i % 100) / 100 * 60 - 30;
    cloud.points.emplace_back(far ? 150.0F : static_cast<float>(i % 7) - 3, far ? 200.0F : along);
    cloud.values.push_back(0);
  }
  view.layers.push_back(cloud);
  view.framing = fit_to_points(view);
  for (const auto& p : cloud.points) {
    const Eigen::Vector2d off = (p.cast<double>() - view.framing.center).cwiseAbs();
    inside += (off.array() <= view.framing.half.array()).all() ? 1U : 0U;
  }
  EXPECT_GE(inside, 950U);
  EXPECT_LT(view.framing.half.x(), 20);
  const Pixels picture = pixels_of(view);
  EXPECT_GT(picture.width - legend, picture.height) << "what is wide makes a wide picture";
  std::swap(view.framing.half.x(), view.framing.half.y());
  const Pixels upright = pixels_of(view);
  EXPECT_LT(upright.width - legend, upright.height);
}

TEST_F(Pictures, AreAsWideAsAskedFor) {
  SnapshotOptions options = of_demo();
  options.output = path("x.png");
  for (const int width : {600, 900}) {
    options.width = width;
    ASSERT_EQ(draw(options), exit_ok) << said;
    EXPECT_EQ(read_png(options.output).width, width);
  }
}

TEST_F(Pictures, CallNothingFreeThatFlattenDidNotSee) {
  SnapshotOptions options = of_demo();
  const auto free_pixels = [&] {
    options.output = path("x.png");
    EXPECT_EQ(draw(options), exit_ok) << said;
    const Pixels picture = read_png(options.output);
    return find(picture, 0, picture.height, [](auto p) { return is_like(p, {219, 242, 227}, 3); }).count;
  };
  EXPECT_GT(free_pixels(), 50'000U) << "the merged scan in profile strict";
  options.areas = "bumper";
  EXPECT_EQ(free_pixels(), 0U) << "a virtual scan in profile flatten";
  options.output = path("x.svg");
  ASSERT_EQ(draw(options), exit_ok);
  EXPECT_THAT(content("x.svg"),
              HasSubstr("bumper has the profile flatten, which proves no place to be free"));
}

TEST_F(Pictures, SayWhenAVirtualScanIsOlderThanTheScansBesideIt) {
  SnapshotOptions options = of_demo();
  options.output = path("x.svg");
  ASSERT_EQ(draw(options), exit_ok);
  // The demo's VLP-16 gives ten clouds a second, its scanners 25 scans.
  EXPECT_THAT(content("x.svg"),
              ::testing::ContainsRegex("bumper: virtual.*taken 0\\.[0-9]+ s before the scans"));
}

}  // namespace
}  // namespace lidard::test
