// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The arguments of static_transform_publisher become the pose of a sensor, or a remark.
#include "daemon/dropin/import.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/angle.h"

namespace lidard {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A launch file of nodes: name, package, type, remaps, parameters.
LaunchNode node(const char* name, const char* package, const char* type, const NodeParameters& parameters,
                const std::map<std::string, std::string>& remaps = {}) {
  return {name, package, type, "/", {}, remaps, parameters};
}

ImportedConfig from_nodes(const std::vector<LaunchNode>& nodes) { return import_nodes({nodes, {}, {}}); }

LaunchNode transform(const std::vector<std::string>& arguments, const char* package = "tf") {
  return {"/publisher", package, "static_transform_publisher", "/", arguments, {}, {}};
}

/// In the frame `laser`.
const LaunchNode scanner = node("/scanner", "urg_node", "urg_node", {{"ip_address", "192.168.0.10"}});

ImportedConfig imported(const std::vector<std::string>& arguments) {
  return from_nodes({scanner, transform(arguments)});
}

/// The pose of the scanner; nothing: it has none.
std::optional<Pose> pose_of(const ImportedConfig& config) {
  return parse_config(config.keys.yaml(), "f").sensors.at(0).pose;
}

TEST(Import, AcceptsSixNumbersAsAPoseWithYawPitchAndRoll) {
  const ImportedConfig config = imported({"1", "2", "0.5", "0.3", "0.2", "0.1", "/base", "/laser", "100"});
  EXPECT_THAT(config.changes, IsEmpty());
  ASSERT_TRUE(pose_of(config));
  EXPECT_TRUE(pose_of(config)->isApprox(make_pose({1, 2, 0.5}, {0.1, 0.2, 0.3}), 1e-9));
}

TEST(Import, AcceptsSevenNumbersAsAPoseWithAQuaternion) {
  const std::string half = std::to_string(std::sqrt(0.5));
  const auto pose = pose_of(imported({"0", "0", "1", "0", "0", half, half, "base", "laser"}));
  ASSERT_TRUE(pose);
  EXPECT_TRUE(pose->isApprox(make_pose({0, 0, 1}, {0, 0, pi_d / 2}), 1e-6));
}

TEST(Import, EveryTransformIsAPoseOrARemark) {
  std::vector<LaunchNode> nodes{
      scanner, node("/planes", "ira_laser_tools", "laserscan_virtualizer",
                    {{"cloud_topic", "/points"}, {"base_frame", "/base"}, {"virtual_laser_scan", "/low"}})};
  for (const char* child : {"laser", "low", "imu"})
    nodes.push_back(transform({"0", "0", "1", "0", "0", "0", "base", child}));
  const ImportedConfig imported = from_nodes(nodes);
  const Config config = parse_config(imported.keys.yaml(), "f");
  ASSERT_TRUE(config.sensors.at(0).pose);
  EXPECT_EQ(config.virtual_scans.at(0).poses.size(), 1U) << "without the slash of tf 1";
  EXPECT_THAT(imported.stays,
              Contains(HasSubstr("the pose of imu in base is not part of this configuration")));
}

TEST(Import, NamesTheFramesOfALoop) {
  std::vector<LaunchNode> nodes{scanner};
  for (const auto& [parent, child] : {std::pair("base", "laser"), {"map", "base"}, {"laser", "map"}})
    nodes.push_back(transform({"0", "0", "1", "0", "0", "0", parent, child}));
  try {
    from_nodes(nodes);
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
    EXPECT_THAT(config.changes, ElementsAre(HasSubstr("/publisher: arguments that make no transform")));
    EXPECT_FALSE(pose_of(config));
  }
}

/// The node of a parameter file.
ImportedConfig from_parameters(const std::string& name, const NodeParameters& parameters) {
  return from_nodes({node(name.c_str(), "", "", parameters)});
}

Config parsed(const ImportedConfig& imported) { return parse_config(imported.keys.yaml(), "f"); }

struct Foreign {
  const char* name;
  NodeParameters parameters;
};

TEST(Import, ParametersOfOtherDriversAreNoSensor) {
  const std::vector<Foreign> others{
      {"/lslidar_driver_node",
       {{"device_ip", "192.168.1.200"}, {"msop_port", "2368"}, {"difop_port", "2369"}}},
      {"/lidar",
       {{"device_ip", "192.168.1.200"}, {"min_range", "0.3"}, {"max_range", "100"}, {"lidar_model", "C16"}}},
      {"/rplidar_node",
       {{"serial_port", "/dev/ttyUSB0"}, {"frame_id", "laser"}, {"angle_compensate", "true"}}},
      {"/lidar", {{"sensor_ip", "192.168.1.201"}, {"frame_id", "hesai"}, {"sensor_model", "Pandar64"}}},
      {"/lidar", {{"sensor_ip", "192.168.1.2"}, {"frame_id", "a"}}},
      {"/lidar",
       {{"sensor_ip", "192.168.1.2"}, {"host_ip", "192.168.1.1"}, {"a", "1"}, {"b", "2"}, {"c", "3"}}},
      {"/lidar", {{"frame_id", "laser"}, {"angle_min", "-1"}, {"angle_max", "1"}, {"port", "2112"}}},
      {"/urg_node", {{"ip_address", "192.168.0.10"}, {"device_ip", "1.2.3.4"}, {"msop_port", "2368"}}},
      {"/velodyne_laserscan_node", {{"ring", "-1"}, {"resolution", "0.007"}}},
      {"/velodyne_transform_node", {{"calibration", "VLP16db.yaml"}, {"min_range", "0.9"}}}};
  for (const Foreign& one : others) {
    const ImportedConfig imported = from_parameters(one.name, one.parameters);
    EXPECT_EQ(imported.entries(), 0U) << one.name << '\n' << imported.keys.yaml();
    EXPECT_EQ(imported.stays.size() + imported.changes.size(), 1U) << one.name;
  }
}

TEST(Import, ANameOrTwoParametersThatAgreeNameTheDriver) {
  const std::vector<std::pair<const char*, Foreign>> known{
      {"sick_microscan3",
       {"/x", {{"sensor_ip", "192.168.1.11"}, {"host_ip", "192.168.1.9"}, {"frame_id", "s"}}}},
      {"sick_microscan3", {"/sick_safetyscanners", {{"sensor_ip", "192.168.1.11"}}}},
      {"hokuyo_scip", {"/front/urg_node", {{"ip_address", "192.168.0.10"}}}},
      {"hokuyo_scip", {"/x", {{"ip_address", "192.168.0.10"}, {"publish_intensity", "true"}}}},
      {"velodyne_hdl32e", {"/velodyne_driver_node", {{"model", "32E"}, {"device_ip", "192.168.1.201"}}}},
      // The name of a scanner of sick_scan_xd is no name of sick_tim.
      {"sick_tim7xx", {"/sick_tim_7xx", {{"scanner_type", "sick_tim_7xx"}, {"hostname", "192.168.0.1"}}}},
      {"velodyne_vlp16", {"/x", {{"sensor_model", "VLP16"}, {"sensor_ip", "192.168.1.201"}}}},
      {"velodyne_vls128", {"/x", {{"sensor_model", "VLS128"}, {"sensor_ip", "192.168.1.201"}}}},
      {"sick_lms1xx", {"/LMS1xx_node", {{"host", "192.168.1.14"}}}}};
  for (const auto& [model, one] : known) {
    const ImportedConfig imported = from_parameters(one.name, one.parameters);
    ASSERT_EQ(imported.entries() - (model == std::string("sick_tim7xx") ? 1 : 0), 1U) << one.name;
    EXPECT_EQ(parsed(imported).sensors.at(0).model->name, model) << one.name;
  }
}

TEST(Import, AVelodyneOfNebulaHasItsPortsAndNoPermissionToWrite) {
  const ImportedConfig imported = from_parameters("/lidar", {{"sensor_model", "VLP32"},
                                                             {"sensor_ip", "192.168.1.201"},
                                                             {"host_ip", "255.255.255.255"},
                                                             {"data_port", "2370"},
                                                             {"gnss_port", "0"},
                                                             {"scan_phase", "90"},
                                                             {"return_mode", "Dual"},
                                                             {"frame_id", "roof"}});
  const SensorConfig sensor = parsed(imported).sensors.at(0);
  EXPECT_EQ(sensor.model->name, "velodyne_vlp32c");
  EXPECT_EQ(sensor.frame_id, "roof");
  const std::string text = imported.keys.yaml();
  for (const char* line :
       {"ip_port: 2370", "telemetry_port: 0", "cut_angle: 1.57", "points_topic: /velodyne_points"})
    EXPECT_THAT(text, HasSubstr(line));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("allow_write")));
  EXPECT_THAT(imported.changes, Contains(HasSubstr("~return_mode (Dual)")));
}

TEST(Import, ACalibrationIsLeftOutWhereTheModelHasThatTable) {
  const auto text = [](const char* model, const char* file) {
    return from_parameters("/velodyne_transform_node", {{"model", model}, {"calibration", file}}).keys.yaml();
  };
  const std::string installed = "/opt/ros/share/velodyne_pointcloud/params/";
  const auto keeps = ::testing::HasSubstr("calibration: ");
  EXPECT_THAT(text("VLP16", "VLP16db.yaml"), ::testing::Not(keeps))
      << "as the parameter files of ROS 2 name it";
  EXPECT_THAT(text("32E", (installed + "32db.yaml").c_str()), ::testing::Not(keeps));
  EXPECT_THAT(text("VLP16", (installed + "32db.yaml").c_str()), keeps) << "the table of another model";
  EXPECT_THAT(text("VLP16", "/home/robot/VLP16db.yaml"), keeps);
}

TEST(Import, OlderDriversBecomeTheirModels) {
  const ImportedConfig imported = from_nodes(
      {node("/a", "lms1xx", "LMS1xx_node", {{"host", "192.168.1.14"}, {"frame_id", "/front"}},
            {{"/scan", "/a/scan"}}),
       node("/b", "sick_tim", "sick_tim551_2050001", {{"hostname", "192.168.1.2"}, {"min_ang", "-1"}}),
       node("/c", "sick_tim", "sick_mrs1000", {{"hostname", "192.168.1.3"}, {"port", "2111"}}),
       node("/d", "sick_scan2", "sick_generic_caller", {{"scanner_type", "sick_lms_5xx"}})});
  const auto sensors = parsed(imported).sensors;
  ASSERT_EQ(sensors.size(), 4U);
  EXPECT_EQ(sensors[0].model->name, "sick_lms1xx");
  EXPECT_EQ(sensors[0].frame_id, "front");
  EXPECT_EQ(sensors[0].scan_topic, "/a/scan");
  EXPECT_EQ(sensors[1].model->name, "sick_tim5xx");
  EXPECT_EQ(sensors[2].model->name, "sick_mrs1000");
  EXPECT_EQ(sensors[2].points_topic, "/cloud");
  EXPECT_EQ(sensors[3].model->name, "sick_lms5xx");
  EXPECT_THAT(imported.changes, Contains(HasSubstr("/d: scan_topic was left out, since another node")));
}

TEST(Import, AScannerAtASerialPortIsRefusedByThatReason) {
  const ImportedConfig imported = from_nodes(
      {node("/a", "hokuyo_node", "hokuyo_node", {{"port", "/dev/ttyACM0"}}),
       node("/b", "urg_node", "urg_node", {{"ip_address", ""}, {"serial_port", "/dev/ttyACM0"}}),
       node("/c", "sick_tim", "sick_tim551_2050001", {}), node("/d", "sick_tim", "sick_tim310", {})});
  EXPECT_EQ(imported.entries(), 0U);
  EXPECT_THAT(imported.changes,
              ElementsAre(HasSubstr("serial"), HasSubstr("serial"), HasSubstr("USB"), HasSubstr("USB")));
}

const LaunchNode velodyne =
    node("/driver", "velodyne_driver", "velodyne_node", {{"model", "VLP16"}, {"frame_id", "velodyne"}});
const LaunchNode points = node("/points", "velodyne_pointcloud", "transform_node", {});

TEST(Import, AFlatScanOfACloudIsAVirtualScan) {
  const ImportedConfig imported =
      from_nodes({node("/flat", "pointcloud_to_laserscan", "pointcloud_to_laserscan_nodelet",
                       {{"target_frame", "/velodyne"},
                        {"min_height", "-0.15"},
                        {"max_height", "0.15"},
                        {"range_min", "0.45"},
                        {"range_max", "100"},
                        {"use_inf", "false"}},
                       {{"/cloud_in", "/velodyne_points"}, {"/scan", "/scan_flat"}}),
                  velodyne, points, transform({"0.2", "0", "0.1", "0", "0", "0", "trunk", "velodyne"})});
  const Config config = parsed(imported);
  const VirtualScanConfig& scan = config.virtual_scans.at(0);
  EXPECT_EQ(config.vehicle.base_frame, "trunk");
  EXPECT_EQ(scan.virtual_laser_scan, std::vector<std::string>{"velodyne"});
  EXPECT_EQ(scan.output_laser_topic, "/scan_flat");
  const std::string text = imported.keys.yaml();
  for (const char* line : {"cloud_topic: driver", "min_height: -0.15", "max_height: 0.15", "range_max: 100",
                           "empty: range_max_plus_one", "angle_increment: 0.01745"})
    EXPECT_THAT(text, HasSubstr(line));
  EXPECT_EQ(scan.poses.size(), 1U);
  EXPECT_THAT(imported.changes, ElementsAre(HasSubstr("stamped by its first ray")));
}

TEST(Import, AFlatScanWithoutTargetIsInTheFrameOfItsSource) {
  const std::map<std::string, std::string> remaps{{"/cloud_in", "/velodyne_points"}};
  const auto flat = node("/flat", "pointcloud_to_laserscan", "pointcloud_to_laserscan_node", {}, remaps);
  EXPECT_EQ(parsed(from_nodes({velodyne, points, flat})).virtual_scans.at(0).virtual_laser_scan.at(0),
            "velodyne");
  EXPECT_EQ(from_nodes({flat}).entries(), 0U);
  EXPECT_THAT(from_nodes({flat}).changes, ElementsAre(HasSubstr("target_frame is empty")));
  const auto back = node("/back", "pointcloud_to_laserscan", "laserscan_to_pointcloud_node", {});
  EXPECT_THAT(from_nodes({back}).stays, ElementsAre(HasSubstr("it stays in a launch file")));
}

const LaunchNode left =
    node("/left", "urg_node", "urg_node", {{"ip_address", "192.168.0.10"}, {"frame_id", "left"}},
         {{"/scan", "/scan_left"}});
const LaunchNode right =
    node("/right", "urg_node", "urg_node", {{"ip_address", "192.168.0.11"}, {"frame_id", "right"}},
         {{"/scan", "/scan_right"}});

TEST(Import, AUnifierIsAMergedScan) {
  const ImportedConfig imported = from_nodes(
      {node("/u", "cob_scan_unifier", "scan_unifier_node", {{"input_scans", "scan_left scan_right"}}), left,
       right});
  const MergedScanConfig merged = parsed(imported).merged_scans.at(0);
  EXPECT_THAT(merged.laserscan_topics, ElementsAre("left", "right"));
  EXPECT_EQ(merged.destination_frame, "base_link");
  EXPECT_EQ(merged.scan_destination_topic, "/scan_unified");
  EXPECT_THAT(imported.changes, ElementsAre(HasSubstr("theirs: range_max")));
}

LaunchNode filters(const NodeParameters& parameters) {
  return node("/filters", "laser_filters", "scan_to_scan_filter_chain", parameters,
              {{"/scan", "/scan_left"}, {"/scan_filtered", "/clean"}});
}

TEST(Import, FiltersAreAMergedScanOfTheSensorAlone) {
  const ImportedConfig imported =
      from_nodes({node("/m", "ira_laser_tools", "laserscan_multi_merger",
                       {{"laserscan_topics", "/clean /scan_right"}, {"destination_frame", "base_link"}}),
                  filters({{"scan_filter_chain/0/name", "range"},
                           {"scan_filter_chain/0/type", "laser_filters/LaserScanRangeFilter"},
                           {"scan_filter_chain/0/params/lower_threshold", "0.3"},
                           {"scan_filter_chain/0/params/upper_threshold", ".inf"},
                           {"scan_filter_chain/1/type", "laser_filters/LaserScanAngularBoundsFilterInPlace"},
                           {"scan_filter_chain/1/params/lower_angle", "1"},
                           {"scan_filter_chain/1/params/upper_angle", "2"},
                           {"scan_filter_chain/2/type", "laser_filters/ScanShadowsFilter"},
                           {"scan_filter_chain/3/type", "laser_filters/LaserScanSpeckleFilter"},
                           {"scan_filter_chain/4/type", "laser_filters/LaserScanBoxFilter"},
                           {"scan_filter_chain/4/params/box_frame", "base_link"},
                           {"scan_filter_chain/4/params/max_x", "0.4"}}),
                  left, right, transform({"1", "0", "0", "0", "0", "0", "base_link", "left"})});
  const Config config = parsed(imported);
  ASSERT_EQ(config.merged_scans.size(), 2U);
  EXPECT_EQ(config.merged_scans[0].scan_destination_topic, "/clean");
  EXPECT_TRUE(config.merged_scans[0].source.veil_filter);
  EXPECT_THAT(config.merged_scans[0].laserscan_topics, ElementsAre("left"));
  EXPECT_THAT(config.merged_scans[1].laserscan_topics, ElementsAre("left", "right"));
  EXPECT_EQ(config.vehicle.footprint.size(), 4U);
  const std::string text = imported.keys.yaml();
  for (const char* line : {"range_min: 0.3", "range_max: 10000", "angle_min: 2", "angle_max: 1"}) {
    const std::string window = std::string("        ") + line;
    EXPECT_NE(text.find(window), text.rfind(window)) << "the merger has the same window: " << text;
  }
  EXPECT_THAT(imported.changes, Contains(HasSubstr("LaserScanSpeckleFilter was left out")));
  EXPECT_THAT(imported.changes, Contains(HasSubstr("became vehicle.footprint")));
}

TEST(Import, FiltersOfAnUnknownScanStay) {
  const ImportedConfig imported = from_nodes({filters({})});
  EXPECT_EQ(imported.entries(), 0U);
  EXPECT_THAT(imported.changes, ElementsAre(HasSubstr("no sensor in this file")));
}

TEST(Import, AVirtualScanIsASourceAndAMergedScanIsNone) {
  const ImportedConfig imported =
      from_nodes({node("/m", "ira_laser_tools", "laserscan_multi_merger",
                       {{"laserscan_topics", "/scan_left /scan_flat"}, {"scan_destination_topic", "/all"}}),
                  node("/again", "ira_laser_tools", "laserscan_multi_merger",
                       {{"laserscan_topics", "/all /scan_right"}, {"scan_destination_topic", "/more"}}),
                  node("/flat", "pointcloud_to_laserscan", "pointcloud_to_laserscan_node", {},
                       {{"/cloud_in", "/velodyne_points"}, {"/scan", "/scan_flat"}}),
                  velodyne, points, left, right});
  const Config config = parsed(imported);
  ASSERT_EQ(config.merged_scans.size(), 1U);
  EXPECT_EQ(config.sensors.size(), 3U) << "an output is no sensor";
  EXPECT_THAT(config.merged_scans[0].laserscan_topics, ElementsAre("left", "/scan_flat"));
  EXPECT_THAT(imported.changes, Contains(HasSubstr("/again was not imported: it reads /all, an output")));
}

TEST(Import, OfTwoPosesOfAFrameThatOfTheDriverIsLeftOut) {
  const ImportedConfig imported =
      from_nodes({node("/tim", "sick_scan_xd", "sick_generic_caller",
                       {{"scanner_type", "sick_tim_5xx"}, {"frame_id", "/laser_2"}}),
                  transform({"2", "0", "0", "0", "0", "0", "map", "laser_2"})});
  EXPECT_TRUE(pose_of(imported)->isApprox(make_pose({2, 0, 0}, {0, 0, 0}), 1e-9));
  EXPECT_THAT(imported.changes,
              ElementsAre(HasSubstr("by /tim (pose: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}) was left "
                                    "out: that by /publisher is another one"),
                          HasSubstr("base_frame is map")));
}

TEST(Import, FixedJointsArePosesBelowBaseLink) {
  const auto joints = [](const char* end) {
    return from_nodes({left, transform({"0", "0", "0.1", "0", "0", "0", "base_footprint", "base_link"}, end),
                       transform({"0.4", "0.2", "0.2", "0.5", "0", "0", "base_link", "left"}, end),
                       transform({"0", "0", "0", "0", "0", "0", "base_link", "camera"}, end)});
  };
  const ImportedConfig imported = joints("robot_state_publisher");
  EXPECT_EQ(parsed(imported).vehicle.base_frame, "base_link");
  EXPECT_TRUE(pose_of(imported)->isApprox(make_pose({0.4, 0.2, 0.2}, {0, 0, 0.5}), 1e-9));
  EXPECT_THAT(imported.changes, IsEmpty());
  EXPECT_THAT(imported.stays, IsEmpty()) << "the description's publisher goes on";
  EXPECT_EQ(joints("tf").stays.size(), 2U);
}

TEST(Import, AJointBelowTheBaseFrameHasTwoParents) {
  const ImportedConfig imported = from_nodes(
      {left, right,
       transform({"0", "0", "0.1", "0", "0", "0", "base_footprint", "base_link"}, "robot_state_publisher"),
       transform({"1", "0", "0.2", "0", "0", "0", "base_link", "left"}, "robot_state_publisher"),
       node("/u", "cob_scan_unifier", "scan_unifier_node",
            {{"input_scans", "/scan_left /scan_right"}, {"frame", "base_footprint"}})});
  EXPECT_TRUE(pose_of(imported)->isApprox(make_pose({1, 0, 0.3}, {0, 0, 0}), 1e-9));
  EXPECT_THAT(imported.changes,
              Contains(HasSubstr("`pose` makes base_footprint the parent of left, which is base_link")));
}

}  // namespace
}  // namespace lidard
