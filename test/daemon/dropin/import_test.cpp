// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What static_transform_publisher says in its arguments becomes the pose of a sensor, or a remark.
#include "daemon/dropin/import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/angle.h"
#include "daemon/config/key_tables.h"

namespace lidard {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A scanner in the frame `laser`, and a node that publishes a transform.
ImportedConfig imported(const std::vector<std::string>& arguments) {
  LaunchFile launch;
  launch.nodes.push_back({"/scanner", "urg_node", "urg_node", "/", {}, {}, {{"ip_address", "192.168.0.10"}}});
  launch.nodes.push_back({"/place", "tf", "static_transform_publisher", "/", arguments, {}, {}});
  return import_nodes(launch);
}

/// The pose of the scanner; nothing: it has none.
std::optional<Pose> pose_of(const ImportedConfig& config) {
  return parse_config(yaml_text(config.keys), "f").sensors.at(0).pose;
}

TEST(Import, TakesSixNumbersAsAPlaceWithYawPitchAndRoll) {
  const ImportedConfig config = imported({"1", "2", "0.5", "0.3", "0.2", "0.1", "/base", "/laser", "100"});
  EXPECT_THAT(config.changes, IsEmpty());
  ASSERT_TRUE(pose_of(config));
  EXPECT_TRUE(pose_of(config)->isApprox(make_pose({1, 2, 0.5}, {0.1, 0.2, 0.3}), 1e-9));
}

TEST(Import, TakesSevenNumbersAsAPlaceWithAQuaternion) {
  const std::string half = std::to_string(std::sqrt(0.5));
  const auto pose = pose_of(imported({"0", "0", "1", "0", "0", half, half, "base", "laser"}));
  ASSERT_TRUE(pose);
  EXPECT_TRUE(pose->isApprox(make_pose({0, 0, 1}, {0, 0, pi_d / 2}), 1e-6));
}

TEST(Import, EveryTransformIsAPoseOrARemark) {
  LaunchFile launch;
  launch.nodes.push_back({"/scanner", "urg_node", "urg_node", "/", {}, {}, {{"ip_address", "192.168.0.10"}}});
  launch.nodes.push_back(
      {"/planes",
       "ira_laser_tools",
       "laserscan_virtualizer",
       "/",
       {},
       {},
       {{"cloud_topic", "/points"}, {"base_frame", "/base"}, {"virtual_laser_scan", "/low"}}});
  for (const char* child : {"laser", "low", "imu"})
    launch.nodes.push_back({"/t",
                            "tf",
                            "static_transform_publisher",
                            "/",
                            {"0", "0", "1", "0", "0", "0", "base", child},
                            {},
                            {}});
  const ImportedConfig imported = import_nodes(launch);
  const Config config = parse_config(yaml_text(imported.keys), "f");
  ASSERT_TRUE(config.sensors.at(0).pose);
  EXPECT_EQ(config.virtual_scans.at(0).poses.size(), 1U) << "without the slash of tf 1";
  EXPECT_THAT(imported.remarks,
              Contains(HasSubstr("the pose of imu in base is not part of this configuration")));
}

TEST(Import, NamesTheFramesOfALoop) {
  LaunchFile launch;
  launch.nodes.push_back({"/scanner", "urg_node", "urg_node", "/", {}, {}, {{"ip_address", "192.168.0.10"}}});
  for (const auto& [parent, child] : {std::pair("base", "laser"), {"map", "base"}, {"laser", "map"}})
    launch.nodes.push_back({"/t",
                            "tf",
                            "static_transform_publisher",
                            "/",
                            {"0", "0", "1", "0", "0", "0", parent, child},
                            {},
                            {}});
  try {
    import_nodes(launch);
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_THAT(error.what(), HasSubstr("form a loop: map in laser in base in map;"));
  }
}

TEST(Import, SaysWhichTransformsItCannotRead) {
  const std::vector<std::vector<std::string>> wrong{
      {"1", "2", "0.5", "0.3", "0", "base", "laser"},
      {"1", "2", "0.5", "0", "0", "0", "1", "1", "base", "laser"},
      {"1", "2", "0.5", "0.3", "0", "0", "laser"},
      {}};
  for (const auto& arguments : wrong) {
    const ImportedConfig config = imported(arguments);
    EXPECT_THAT(config.changes, ElementsAre(HasSubstr("/place: arguments that make no transform")));
    EXPECT_FALSE(pose_of(config));
  }
}

}  // namespace
}  // namespace lidard
