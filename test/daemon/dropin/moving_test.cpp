// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/moving.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "test/support/captures.h"

namespace lidard {
namespace {

using ::testing::HasSubstr;

/// A package with what its node needs to make sense, and its parameters as the node's sources have them
/// (versions as in the table): the list that the table must cover.
struct Case {
  std::string_view package;
  DropinSetup (*setup)(const NodeParameters&);
  NodeParameters needed;
  const char* list;
};

std::vector<Case> cases() {
  return {
      {"sick_safetyscanners",
       safety_scanners_setup,
       {},
       "sensor_ip host_ip interface_ip host_udp_port frame_id skip angle_start angle_end min_intensities "
       "channel "
       "channel_enabled general_system_state derived_settings measurement_data intrusion_data "
       "application_io_data "
       "use_persistent_config expected_frequency frequency_tolerance timestamp_min_acceptable "
       "timestamp_max_acceptable time_offset"},
      {"urg_node",
       urg_node_setup,
       {},
       "ip_address ip_port serial_port serial_baud frame_id tf_prefix calibrate_time synchronize_time "
       "publish_intensity publish_multiecho error_limit diagnostics_tolerance diagnostics_window_time "
       "get_detailed_status time_offset angle_min angle_max cluster skip error_reset_period"},
      {"sick_scan_xd",
       sick_scan_setup,
       {{"scanner_type", "sick_tim_7xx"}, {"user_level", "3"}, {"user_level_password", "F4724744"}},
       "scanner_type hostname port min_ang max_ang use_binary_protocol range_min range_max "
       "range_filter_handling "
       "intensity intensity_resolution_16bit ang_res scan_freq skip cloud_topic laserscan_topic frame_id "
       "timelimit "
       "sw_pll_only_publish use_generation_timestamp tick_to_timestamp_mode start_services activate_lferec "
       "activate_lidoutputstate activate_lidinputstate active_field_set field_set_selection_method "
       "min_intensity "
       "scandatacfg_timingflag encoder_mode add_transform_xyz_rpy add_transform_check_dynamic_updates "
       "message_monitoring_enabled read_timeout_millisec_default read_timeout_millisec_startup "
       "read_timeout_millisec_kill_node user_level user_level_password ros_qos tf_base_frame_id "
       "tf_base_lidar_xyz_rpy tf_publish_rate ntp_server_address new_IP_address"},
      {"sick_scan_xd",
       sick_scan_setup,
       {{"scanner_type", "sick_picoscan"}},
       "hostname udp_receiver_ip udp_sender udp_port check_udp_receiver_ip check_udp_receiver_port "
       "listen_only_mode "
       "scandataformat performanceprofilenumber all_segments_min_deg all_segments_max_deg publish_frame_id "
       "publish_laserscan_segment_topic publish_laserscan_fullframe_topic laserscan_layer_filter "
       "udp_input_fifolength msgpack_output_fifolength udp_timeout_ms udp_timeout_ms_initial imu_enable "
       "imu_udp_port imu_latency_microsec imu_topic sopas_tcp_port send_sopas_start_stop_cmd "
       "sopas_cola_binary "
       "host_FREchoFilter host_set_FREchoFilter host_LFPangleRangeFilter host_LFPintervalFilter "
       "host_read_filtersettings msgpack_validator_enabled msgpack_validator_required_echos "
       "custom_pointclouds "
       "cloud_unstructured_fullframe cloud_polar_unstructured_segments tick_to_timestamp_mode"},
      {"ros-drivers/velodyne",
       velodyne_node_setup,
       {{"model", "VLP16"}},
       "frame_id model rpm npackets timestamp_first_packet pcap cut_angle port device_ip gps_time pcap_time "
       "read_once read_fast repeat_delay diagnostic_frequency_tolerance time_offset enabled calibration "
       "min_range "
       "max_range view_direction view_width fixed_frame target_frame organize_cloud ring resolution manager "
       "laserscan_ring laserscan_resolution"},
      {"ira_laser_tools",
       laser_merger_setup,
       {{"laserscan_topics", "/a /b"}},
       "destination_frame cloud_destination_topic scan_destination_topic laserscan_topics angle_min "
       "angle_max "
       "angle_increment scan_time range_min range_max time_increment"},
      {"ira_laser_tools",
       laser_virtualizer_setup,
       {{"virtual_laser_scan", "a b"}},
       "base_frame cloud_topic output_laser_topic virtual_laser_scan angle_min angle_max angle_increment "
       "scan_time "
       "range_min range_max time_increment"}};
}

const MovedParameter* row_of(std::string_view package, const std::string& name) {
  for (const MovedParameter& row : moved_package(package).parameters) {
    for (const std::string& one : split_words(row.names)) {
      const bool is_prefix =
          one.back() == '*' && name.compare(0, one.size() - 1, one, 0, one.size() - 1) == 0;
      if (one == name || is_prefix) return &row;
    }
  }
  return nullptr;
}

/// A value that is not the default, and that means something beside the values of `needed`.
std::string sample_of(const std::string& name) {
  // Names and their values by turns.
  static const std::vector<std::string> samples = split_words(
      "sensor_ip 192.168.7.1 host_ip 192.168.7.2 ip_address 192.168.7.1 hostname 192.168.7.1 device_ip "
      "192.168.7.1 udp_receiver_ip 192.168.7.2 host_udp_port 6061 port 2377 udp_port 2377 ip_port "
      "10941 frame_id a_frame publish_frame_id a_frame tf_prefix robot base_frame a_frame "
      "destination_frame a_frame timestamp_first_packet true organize_cloud true publish_intensity "
      "false publish_multiecho true calibrate_time true intensity false listen_only_mode true "
      "activate_lferec true activate_lidoutputstate true activate_lidinputstate true "
      "user_level_password 12345678 model 32E tf_base_lidar_xyz_rpy 1,2,3,0,0,0 tf_publish_rate 0 "
      "add_transform_xyz_rpy 0,0,1,3.14159,0,0 time_increment 0.001 user_level 4 angle_start -0.5 "
      "cluster 2 skip 3 max_range 50 ring 2 laserscan_ring 2 resolution 0.01 laserscan_resolution 0.01 "
      "host_FREchoFilter 1 cloud_destination_topic other scan_destination_topic other cloud_topic "
      "other laserscan_topic other output_laser_topic other publish_laserscan_fullframe_topic other "
      "tf_base_frame_id a_frame custom_pointclouds fog");
  if (name == "virtual_laser_scan") return "c d";
  if (name == "laserscan_topics") return "/c /d";
  for (std::size_t i = 0; i < samples.size(); i += 2) {
    if (samples[i] == name) return samples[i + 1];
  }
  return "0.5";
}

/// The whole setup except the remarks.
std::string meaning(const DropinSetup& setup) {
  std::ostringstream text;
  text << setup.keys.yaml();
  for (const auto& one : setup.transforms)
    text << one.parent << ' ' << one.child << ' ' << one.pose.matrix() << '\n';
  return text.str();
}

std::string remarks_of(const DropinSetup& setup) {
  std::string text;
  for (const auto* list : {&setup.warnings, &setup.remarks}) {
    for (const auto& one : *list) text += one + "\n";
  }
  return text;
}

TEST(Moving, TheTablesCoverEveryParameterOfThePackages) {
  for (const Case& one : cases()) {
    for (const std::string& name : split_words(one.list))
      EXPECT_NE(row_of(one.package, name), nullptr) << one.package << ": " << name;
  }
}

TEST(Moving, AParameterWithAKeyChangesTheConfigurationAndOneWithoutIsReported) {
  // What is no key of a configuration but of `lidard replay`, and what one model has no use for.
  const std::set<std::string> elsewhere{"pcap",      "read_once",   "read_fast",    "repeat_delay",
                                        "pcap_time", "calibration", "scanner_type", "model"};
  for (const Case& one : cases()) {
    const std::string before = meaning(one.setup(one.needed));
    EXPECT_NO_THROW(parse_config(one.setup(one.needed).keys.yaml(), "p")) << before;
    for (const std::string& name : split_words(one.list)) {
      const MovedParameter& row = *row_of(one.package, name);
      NodeParameters parameters = one.needed;
      if (elsewhere.count(name) != 0) continue;
      parameters[name] = row.key.empty() ? "7" : sample_of(name);
      const DropinSetup after = one.setup(parameters);
      // Keys that one model has no use for are reported instead, key by key.
      const bool is_left_out =
          remarks_of(after).find("key " + std::string(row.key) + " was left out") != std::string::npos;
      if (row.key.empty()) {
        EXPECT_THAT(remarks_of(after), HasSubstr("~" + name + " (7)")) << one.package;
      } else if (!is_left_out) {
        EXPECT_NE(meaning(after), before) << one.package << " ~" << name;
      }
      EXPECT_THAT(remarks_of(after), ::testing::Not(HasSubstr("~" + name + " is not known")));
      EXPECT_NO_THROW(parse_config(after.keys.yaml(), "p")) << name << '\n' << after.keys.yaml();
    }
  }
}

TEST(Moving, EachRowOfTheTableIsRead) {
  std::ifstream table(test::project_file("config/moving_over.tsv"));
  const std::map<std::string, std::ptrdiff_t> tabs{{"package", 5}, {"parameter", 5}, {"topic", 3}};
  std::size_t rows = 0, read = 0;
  for (std::string row; std::getline(table, row);) {
    const auto kind = tabs.find(row.substr(0, row.find('\t')));
    if (kind == tabs.end()) continue;
    ++rows;
    EXPECT_EQ(std::count(row.begin(), row.end(), '\t'), kind->second) << row;
    EXPECT_EQ(row.find('|'), std::string::npos) << "a cell of the page ends there: " << row;
  }
  for (const MovedPackage& package : moved_packages())
    read += 1 + package.parameters.size() + package.topics.size();
  EXPECT_GT(rows, 100U);
  EXPECT_EQ(read, rows) << "a conversion that is not known?";
}

TEST(Moving, ThePageOfTheManualHasTheTables) {
  EXPECT_THAT(test::content(test::project_file("config/doc/moving_over.md")), HasSubstr(moved_markdown()))
      << "lidard import --tables";
}

// x, y, z, roll, pitch, yaw of the points in the frame whose place tf_base_lidar_xyz_rpy says.
TEST(Moving, WhatMovesThePointsOfASickBesidesTfIsPartOfItsPose) {
  const NodeParameters upside_down{{"scanner_type", "sick_lrs_36x0"},
                                   {"tf_base_lidar_xyz_rpy", "1,2,3,0,0,1.5707963"},
                                   {"add_transform_xyz_rpy", "0.5,0,0,3.1415927,0,0"}};
  const DropinSetup setup = sick_scan_setup(upside_down);
  ASSERT_EQ(setup.transforms.size(), 1U);
  const Eigen::Vector3d seen = setup.transforms[0].pose * Eigen::Vector3d(4, 1, 0);
  EXPECT_LT((seen - Eigen::Vector3d(1 + 1, 2 + 4.5, 3)).norm(), 1e-5) << seen;
  ASSERT_EQ(setup.warnings.size(), 1U);
  EXPECT_THAT(setup.warnings[0], HasSubstr("add_transform_xyz_rpy"));

  NodeParameters elsewhere = upside_down;
  elsewhere["tf_publish_rate"] = "0";
  const DropinSetup own = sick_scan_setup(elsewhere);
  ASSERT_EQ(own.transforms.size(), 1U);
  EXPECT_EQ(own.transforms[0].parent, "cloud");
  EXPECT_EQ(own.transforms[0].child, parse_config(own.keys.yaml(), "p").sensors.at(0).frame_id);
  EXPECT_LT((own.transforms[0].pose * Eigen::Vector3d(4, 1, 0) - Eigen::Vector3d(4.5, -1, 0)).norm(), 1e-5);
  elsewhere["add_transform_xyz_rpy"] = "0.5,0,0";
  EXPECT_THROW(sick_scan_setup(elsewhere), ConfigError);
}

}  // namespace
}  // namespace lidard
