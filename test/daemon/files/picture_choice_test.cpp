// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Pictures of one output alone, and intensities as colours.
#include <numeric>

#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/sink.h"
#include "test/daemon/files/pictures_support.h"

namespace lidard::test {
namespace {

/// A scanner's view of the beams with these states; the ranges are 5 m.
SnapshotView view_of(const std::vector<BeamStatus>& statuses, const std::vector<float>& intensities,
                     bool by_intensity) {
  const Config config = parse_config(
      "sensors: {a: {model: sick_tim7xx, ip_address: 10.0.0.1, frame_id: a, pose: {xyz: [0, 0, 0]}}}", "f");
  PlanarScan scan;
  scan.frame_id = "a";
  scan.reset(statuses.size(), 1, !intensities.empty());
  scan.set_angles(-2, 4 / static_cast<float>(statuses.size()));
  scan.range_max = 30;
  for (std::size_t i = 0; i < statuses.size(); ++i) {
    if (statuses[i] == BeamStatus::hit)
      scan.set_hit(i, 5);
    else
      scan.set_without_hit(i, statuses[i]);
  }
  scan.intensities = intensities;
  FrameKeeper frames;
  frames.publish(frame_topic(config.sensors[0]), scan, Stamp{});
  NoTransforms no_tf;
  SnapshotView view = make_view(config, FrameTree(config.vehicle.base_frame, fixed_poses(config), no_tf),
                                frames, {"", {}, by_intensity});
  view.framing = fit_to_points(view);
  fit_colors(view, by_intensity);
  return view;
}

/// The numbers before percent signs.
std::vector<int> percentages_in(const std::string& text) {
  std::vector<int> all;
  for (std::size_t at = text.find('%'); at != std::string::npos; at = text.find('%', at + 1))
    all.push_back(std::stoi(text.substr(text.find_last_not_of("0123456789", at - 1) + 1)));
  return all;
}

TEST_F(Pictures, HavePercentagesThatAddUp) {
  using S = BeamStatus;
  struct Case {
    std::size_t free, unknown, near;
    std::vector<int> shares;
  };
  for (const Case& one : {Case{101, 99, 0, {51, 49}}, Case{99, 101, 0, {49, 51}}, Case{1, 1, 1, {33, 33, 33}},
                          Case{996, 2, 2, {100, 0}}, Case{5, 0, 0, {100, 0}}, Case{14, 3, 3, {70, 15, 15}}}) {
    std::vector<S> beams(one.free, S::none);
    beams.insert(beams.end(), one.unknown, S::invalid);
    beams.insert(beams.end(), one.near, S::near);
    const SnapshotView view = view_of(beams, {}, false);
    std::vector<int> shares = percentages_in(view.free_note + view.unobserved_note);
    const int sum = std::accumulate(shares.begin(), shares.end(), 0);
    EXPECT_EQ(sum, 100) << view.free_note << view.unobserved_note;
    ASSERT_EQ(shares.size(), one.shares.size()) << view.unobserved_note;
    for (std::size_t i = 0; i < shares.size(); ++i) EXPECT_NEAR(shares[i], one.shares[i], 1);
  }
}

TEST_F(Pictures, HaveTheColoursOfIntensitiesOnTheScaleOfEachScan) {
  std::vector<float> intensities(400, 20);
  std::fill(intensities.begin(), intensities.begin() + 200, 4000.0F);
  SnapshotView view = view_of(std::vector<BeamStatus>(400, BeamStatus::hit), intensities, true);
  EXPECT_THAT(view.layers[0].note, HasSubstr("intensity 20 to 4000"));
  EXPECT_THAT(view.colors_note, HasSubstr("intensity"));
  const Pixels picture = pixels_of(view);
  // The beams begin at the right.
  const auto strong = find(picture, 76, picture.height, [](auto p) {
    return is_like(p, {170, 220, 50}, 25);
  });
  const auto weak = find(picture, 76, picture.height, [](auto p) { return is_like(p, {68, 1, 84}, 25); });
  ASSERT_GT(strong.count, 300U);
  ASSERT_GT(weak.count, 300U);
  EXPECT_GT(strong.x, weak.x + 100);
  const SnapshotView by_height = view_of(std::vector<BeamStatus>(400, BeamStatus::hit), intensities, false);
  EXPECT_TRUE(by_height.layers[0].values.empty());
  EXPECT_EQ(by_height.colors_note, "") << "a planar scan has no heights";
}

TEST_F(Pictures, SayWhereThereAreNoIntensities) {
  for (const std::vector<float>& absent : {std::vector<float>(), std::vector<float>(400, 0.0F)}) {
    SnapshotView view = view_of(std::vector<BeamStatus>(400, BeamStatus::hit), absent, true);
    EXPECT_THAT(view.layers[0].note, HasSubstr("no intensities"));
    EXPECT_EQ(view.colors_note, "");
    const Pixels picture = pixels_of(view);
    const auto own = [](auto p) { return is_like(p, {0, 115, 179}, 25); };
    EXPECT_GT(find(picture, 76, picture.height, own).count, 300U) << "the colour of the scan";
  }
}

TEST_F(Pictures, HaveIntensitiesOfCloudsAndScansOfACapture) {
  SnapshotOptions options = of_demo();
  options.color = "intensity";
  options.output = path("x.svg");
  ASSERT_EQ(draw(options), exit_ok) << said;
  EXPECT_THAT(content("x.svg"),
              AllOf(HasSubstr("colours: lowest to highest intensity of each"),
                    ::testing::ContainsRegex("\nfront_left/scan: microScan3, 706 beams, intensity [0-9]"),
                    ::testing::ContainsRegex("\nroof/points: cloud, [0-9]+ points, intensity [0-9]")));
  options.captures.clear();
  EXPECT_EQ(draw(options), exit_usage);
  EXPECT_THAT(said, HasSubstr("a capture is required"));
}

TEST_F(Pictures, OfOneOutputHaveNoOther) {
  SnapshotOptions options = of_demo();
  options.output = path("x.svg");
  options.only = {"bumper", "front_left/scan"};
  ASSERT_EQ(draw(options), exit_ok) << said;
  EXPECT_THAT(content("x.svg"), AllOf(HasSubstr("\nbumper: virtual"), HasSubstr("\nfront_left/scan: micro"),
                                      Not(HasSubstr("front_right")), Not(HasSubstr("\nscan_multi:")),
                                      Not(HasSubstr("roof/points:")), Not(HasSubstr("colours:"))));
  options.areas = "scan_strict";
  ASSERT_EQ(draw(options), exit_ok) << said;
  EXPECT_THAT(content("x.svg"), HasSubstr("says scan_strict"));
  options.only = {"front_left/scan", "front_middle/scan"};
  options.areas.clear();
  EXPECT_EQ(draw(options), exit_failed);
  EXPECT_THAT(said,
              AllOf(HasSubstr("--only: no output 'front_middle/scan' can be drawn"),
                    HasSubstr("bumper, chest, front_left/scan, front_right/scan, roof/points, scan_multi, "
                              "scan_safety, scan_strict\n")));
}

TEST_F(Pictures, OfOneOutputInAnEmptyFieldHaveNoOther) {
  SnapshotOptions options = of_demo();
  options.captures.clear();
  options.output = path("x.svg");
  for (const auto& [topic, other] : {std::pair("chest", "bumper:"), {"front_left/scan", "front_right"}}) {
    options.only = {topic};
    ASSERT_EQ(draw(options), exit_ok) << said;
    EXPECT_THAT(content("x.svg"), AllOf(HasSubstr(std::string("\n") + topic + ": "), Not(HasSubstr(other))));
  }
  options.only = {"nothing"};
  EXPECT_EQ(draw(options), exit_failed);
  EXPECT_THAT(said, HasSubstr("no output 'nothing' can be drawn"));
}

}  // namespace
}  // namespace lidard::test
