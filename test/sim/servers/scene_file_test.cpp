// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/servers/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace {

using namespace lidard;
using namespace lidard::sim;
using testing::HasSubstr;
using testing::StartsWith;

const char* const good =
    "start: 2026-01-01T00:00:00Z\n"
    "duration: 1\n"
    "sensors:\n"
    "  a: {model: velodyne_vlp16, from: '10.0.0.1:1', to: '10.0.0.2:2'}\n";

std::string complaint(const std::string& text) {
  try {
    parse_scene(text, "s.yaml");
  } catch (const SceneError& error) {
    return error.what();
  }
  return "none";
}

TEST(SceneFile, DefaultsComeFromTheModel) {
  const Scene scene = parse_scene(good, "s.yaml");
  ASSERT_EQ(scene.sensors.size(), 1U);
  EXPECT_EQ(scene.sensors[0].range_max, 100);
  EXPECT_EQ(scene.sensors[0].from.to_string(), "10.0.0.1:1");
  EXPECT_EQ(scene.start.ns, 1767225600'000000000);
  EXPECT_FALSE(scene.ground.has_value());
}

TEST(SceneFile, TimeMayHaveAFractionDownToNanoseconds) {
  std::string text = good;
  text.replace(text.find("00Z"), 3, "07.000000042Z");
  EXPECT_EQ(parse_scene(text, "s.yaml").start.ns, 1767225607'000000042);
}

TEST(SceneFile, UnknownKeyIsNamedWithItsPlaceAndTheKnownOnes) {
  EXPECT_EQ(
      complaint(std::string(good) + "colour: red\n"),
      "s.yaml:5:1: unknown key 'colour'; expected one of start, duration, seed, ground, vehicle, sensors, "
      "objects");
}

TEST(SceneFile, EveryMistakeIsToldWithItsPlace) {
  const std::string base = good;
  const auto with = [&](const std::string& more) { return complaint(base + more); };
  EXPECT_THAT(complaint("start: today\nduration: 1\n"),
              StartsWith("s.yaml:1:8: 'today' is not a time; expected"));
  EXPECT_THAT(complaint("start: 2026-01-01T00:00:00.5\nduration: 1\n"), HasSubstr("is not a time"));
  EXPECT_THAT(complaint("start: 2026-01-01T00:00:00Z\nduration: -1\n"),
              StartsWith("s.yaml:2:11: duration must"));
  EXPECT_THAT(complaint("duration: 1\n"), HasSubstr("'start' is missing"));
  EXPECT_THAT(with("objects: [{box: {size: [1, 1]}}]\n"),
              HasSubstr("s.yaml:5:24: a list of 2 values; expected 3"));
  EXPECT_THAT(with("objects: [{box: {center: [1, 1, 1], size: [1, 0, 1]}}]\n"), HasSubstr("longer than 0"));
  EXPECT_THAT(with("objects: [{sphere: {}}]\n"), HasSubstr("unknown key 'sphere'"));
  EXPECT_THAT(with("objects: [{wall: {from: [0, 0], to: [1, 1], z: [2, 1]}}]\n"),
              HasSubstr("lower one first"));
  EXPECT_THAT(with("objects: [{cylinder: {radius: 1, height: 1, waypoints: []}}]\n"),
              HasSubstr("at least one"));
  EXPECT_THAT(
      with("objects: [{cylinder: {radius: 1, height: 1, waypoints: [{at: 1, center: [0, 0, 0]}, {at: 1, "
           "center: [0, 0, 1]}]}}]\n"),
      HasSubstr("times must ascend"));
  EXPECT_THAT(with("vehicle: {odometry: {rate: 0}}\n"), HasSubstr("s.yaml:5:"));
  EXPECT_THAT(with("objects: 5\n"), HasSubstr("s.yaml:5:10: expected a list"));
  EXPECT_THAT(with("ground: {z: low}\n"), HasSubstr("'low' is not a number"));
  EXPECT_THAT(with("seed: 1.5\n"), HasSubstr("not a whole number"));
  EXPECT_THAT(with("ground: {z: [\n"), StartsWith("s.yaml:"));
}

TEST(SceneFile, EveryMistakeOfASensorIsToldWithItsPlace) {
  const auto sensor = [](const std::string& model, const std::string& more) {
    return complaint("start: 2026-01-01T00:00:00Z\nduration: 1\nsensors:\n  a: {model: " + model +
                     ", to: '10.0.0.2:2', " + more + "}\n");
  };
  const std::string from = "from: '10.0.0.1:1', ";
  EXPECT_THAT(sensor("laser9", from),
              HasSubstr("s.yaml:4:14: unknown model 'laser9'; expected one of velodyne_vlp16"));
  EXPECT_THAT(sensor("velodyne_vlp16", "from: here"), HasSubstr("'here' is not an address with a port"));
  EXPECT_THAT(sensor("velodyne_vlp16", "from: '10.0.0.1:70000'"), HasSubstr("not an address with a port"));
  EXPECT_THAT(sensor("velodyne_vlp16", from + "noise: -1"), HasSubstr("must not be negative"));
  EXPECT_THAT(sensor("velodyne_vlp16", from + "range_offset: far"), HasSubstr("'far' is not a number"));
  EXPECT_THAT(sensor("velodyne_vlp16", from + "knocked: {by: 1}"), HasSubstr("unknown key 'by'"));
  EXPECT_THAT(sensor("velodyne_vlp16", from + "options: {return_mode: first}"),
              HasSubstr("unknown return mode"));
  EXPECT_THAT(sensor("velodyne_vlp16", from + "options: {pps_locked: 1}"), HasSubstr("true or false"));
  EXPECT_THAT(sensor("sick_microscan3", from + "options: {rpm: 600}"), HasSubstr("unknown key 'rpm'"));
  EXPECT_THAT(sensor("sick_microscan3", from + "options: {start_deg: 90, end_deg: 0}"),
              HasSubstr("less than"));
  EXPECT_THAT(sensor("sick_microscan3", from + "options: {resolution_deg: 0.001}"), HasSubstr("do not fit"));
  EXPECT_THAT(complaint("start: 2026-01-01T00:00:00Z\nduration: 1\nsensors: {}\n"),
              HasSubstr("at least one sensor"));
}

TEST(SceneFile, MissingFileIsOneClearMessage) {
  try {
    load_scene("/nowhere/scene.yaml");
    FAIL();
  } catch (const SceneError& error) {
    EXPECT_STREQ(error.what(), "/nowhere/scene.yaml: cannot be read; name an existing scene file");
  }
}

TEST(SceneFile, SteadyVelocityPassesTheCentreAtTheStart) {
  const Scene scene = parse_scene(std::string(good) +
                                      "objects: [{box: {center: [1, 2, 3], size: [1, 1, 1], yaw_deg: 30, "
                                      "velocity: [0.5, -1, 0], yaw_rate_deg: 10}}]\n",
                                  "s.yaml");
  const Pose at_start = pose_at(scene.objects[0], 0);
  const Pose later = pose_at(scene.objects[0], 2);
  EXPECT_TRUE(at_start.isApprox(make_pose({1, 2, 3}, {0, 0, 30 * rad_per_deg}), 1e-9));
  EXPECT_TRUE(later.isApprox(make_pose({2, 0, 3}, {0, 0, 50 * rad_per_deg}), 1e-9));
}

}  // namespace
