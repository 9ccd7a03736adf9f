// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "core/base/number_text.h"
#include "daemon/dropin/moving.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

/// sick_scan_xd's names of scanner types (include/sick_scan/sick_generic_parser.h), and ours.
struct ScannerType {
  std::string_view theirs, ours;
  bool other_port = false;  ///< they speak another protocol there than lidard does
};
constexpr ScannerType scanner_types[] = {{"sick_lms_1xx", "sick_lms1xx"},
                                         {"sick_lms_1xxx", "sick_lms1000"},
                                         {"sick_lms_4xxx", "sick_lms4000"},
                                         {"sick_lms_5xx", "sick_lms5xx"},
                                         {"sick_tim_240", "sick_tim240"},
                                         {"sick_tim_4xx", "sick_tim4xx"},
                                         {"sick_tim_5xx", "sick_tim5xx"},
                                         {"sick_tim_7xx", "sick_tim7xx"},
                                         {"sick_tim_7xxS", "sick_tim7xxs"},
                                         {"sick_mrs_1xxx", "sick_mrs1000"},
                                         {"sick_lrs_36x0", "sick_lrs36x0"},
                                         {"sick_lrs_36x1", "sick_lrs36x1"},
                                         {"sick_lrs_4xxx", "sick_lrs4000", true},
                                         {"sick_nav_2xx", "sick_nav2xx"},
                                         {"sick_nav_31x", "sick_nav31x"},
                                         {"sick_oem_15xx", "sick_oem15xx"},
                                         {"sick_picoscan", "sick_picoscan150"},
                                         {"sick_multiscan", "sick_multiscan136"},
                                         {"sick_scansegment_xd", "sick_multiscan136"}};

const char* const device_setting =
    "a setting of the device: SOPAS ET or its web page keeps it, nobody has to send it";
const char* const other_device = "of a device that lidard does not read";

KeyValue true_if_true(const std::string& value) {
  return value == "true" || value == "True" || value == "1" ? KeyValue(true) : KeyValue();
}

const ScannerType& type_of(const std::string& given) {
  std::string known;
  for (const ScannerType& type : scanner_types) {
    if (given == type.theirs) return type;
    known.append(known.empty() ? "" : ", ").append(type.theirs);
  }
  throw ConfigError("parameter ~scanner_type is '" + given +
                    "', a device that lidard does not read; it reads " + known);
}

/// "x,y,z,roll,pitch,yaw", m and rad.
Pose read_pose(ParameterReader& reader, const std::string& name) {
  const std::string given = reader.text(name, "0,0,0,0,0,0");
  std::string text = given;
  std::replace(text.begin(), text.end(), ',', ' ');
  std::vector<double> numbers;
  for (const auto& word : split_words(text)) {
    const auto number = number_in<double>(word);
    if (number) numbers.push_back(*number);
  }
  if (numbers.size() != 6 || split_words(text).size() != 6)
    throw ConfigError("parameter ~" + name + " is '" + given + "'; expected six numbers");
  return make_pose({numbers[0], numbers[1], numbers[2]}, {numbers[3], numbers[4], numbers[5]});
}

/// The sensor's pose: where tf has its frame, and how sick_scan_xd moved the points in that frame. Where
/// another node says where the frame is, the sensor gets a frame of its own in it.
void place_sensor(ParameterReader& reader, std::string& frame, DropinSetup& setup) {
  const std::string base = reader.text("tf_base_frame_id", "map");
  const double rate = reader.number("tf_publish_rate", 10);
  const Pose mounted = read_pose(reader, "tf_base_lidar_xyz_rpy");
  const Pose moved = read_pose(reader, "add_transform_xyz_rpy");
  const bool is_moved = !moved.isApprox(Pose::Identity());
  if (is_moved && rate <= 0) setup.transforms.push_back({frame, frame + "_device", moved});
  if (is_moved && rate <= 0) frame += "_device";
  if (is_moved)
    setup.warnings.push_back("parameter ~add_transform_xyz_rpy is part of the pose of " + frame +
                             ": it moves the scan with the cloud, while sick_scan_xd moved the cloud alone");
  if (rate > 0) setup.transforms.push_back({base, frame, mounted * moved});
  if (rate > 0 && base == "map")
    setup.remarks.emplace_back(
        "vehicle.base_frame is map, which is where sick_scan_xd hangs a sensor unless told "
        "otherwise; the frame of a vehicle is wanted there");
}

/// One without the other means nothing: sick_scan_xd has a default for it, which is that of the device too.
void pair_login(KeyMap& sensor, DropinSetup& setup) {
  const auto is_login = [](const auto& one) { return one.first.compare(0, 10, "user_level") == 0; };
  if (std::count_if(sensor.begin(), sensor.end(), is_login) != 1) return;
  sensor.erase(std::remove_if(sensor.begin(), sensor.end(), is_login), sensor.end());
  setup.warnings.emplace_back(
      "one of ~user_level and ~user_level_password alone was left out: both are needed");
}

}  // namespace

const MovedPackage& moved_sick_scan() {
  static const MovedPackage package{
      "sick_scan_xd",
      "sick_scan_xd sick_scan",
      "launch/*.launch and driver/src (3.9.0)",
      {{"scanner_type", "model",
        "sick_tim_7xx is sick_tim7xx, and so on; sick_picoscan is sick_picoscan150, sick_multiscan is "
        "sick_multiscan136, or 165 with layer_lookup_table_id 1"},
       {"layer_lookup_table_id", "model", "1: sick_multiscan165"},
       {"hostname", "ip_address", "an address, as it is; names of hosts are not looked up"},
       {"port", "ip_port",
        "as it is, of devices that are read over TCP; an LRS4000 is read from another one"},
       {"udp_port", "ip_port", "as it is, of devices that stream over UDP", "", copied},
       {"udp_receiver_ip", "udp_receiver_ip", "as it is; empty: the device sends here already", "", copied},
       {"listen_only_mode", "listen_only", "as it is; then nothing is written to the device", "",
        true_if_true},
       {"frame_id publish_frame_id", "frame_id", "as it is, without suffix for layers and echoes"},
       {"min_ang", "angle_min", "rad, as it is, of planar scanners", "", copied},
       {"max_ang", "angle_max", "rad, as it is, of planar scanners", "", copied},
       {"laserscan_topic publish_laserscan_fullframe_topic", "scan_topic", "as it is, of planar scanners"},
       {"cloud_topic", "points_topic cloud_destination_topic",
        "as it is, of multi-plane lidars; of a planar one that of a merged scan of it alone"},
       {"intensity", "publish_intensity", "as it is, of planar scanners", "", copied},
       {"skip", "skip", "as it is, of devices that speak CoLa", "", copied},
       {"time_offset", "time_offset", "s, as it is", "", copied},
       {"activate_lferec activate_lidoutputstate activate_lidinputstate", "publish_states",
        "true if one of them is; of devices that speak CoLa", "", true_if_true},
       {"user_level", "user_level", "as it is", "", copied},
       {"user_level_password", "user_level_password", "as it is, the hash of the password", "", copied},
       {"host_FREchoFilter", "publish_multiecho", "1: true; others are settings of the device", "",
        [](const std::string& value) { return value == "1" ? KeyValue(true) : KeyValue(); }},
       {"tf_base_frame_id tf_base_lidar_xyz_rpy tf_publish_rate", "pose",
        "of the sensor in vehicle.base_frame, on /tf_static; a rate of 0: none"},
       {"add_transform_xyz_rpy", "pose",
        "part of the pose; with a tf_publish_rate of 0 the sensor has the frame FRAME_device, and its pose "
        "in "
        "FRAME"},
       {"add_transform_check_dynamic_updates", "", "a pose is changed with a new configuration", "false"},
       {"all_segments_min_deg all_segments_max_deg", "",
        "a frame ends where the device ends it; angle_min_deg and angle_max_deg crop a scan", "*"},
       {"publish_laserscan_segment_topic", "",
        "scans are published whole; a scan is on its way within a ms of its "
        "last segment"},
       {"laserscan_layer_filter scan_layer_filter", "",
        "virtual_scans make a LaserScan of any plane of a multi-plane lidar"},
       {"custom_pointclouds cloud_unstructured_* cloud_structured_* cloud_polar_* cloud_all_fields_* "
        "cloud_structured "
        "cloud_output_mode filter_echos imu_frame_id publish_imu_frame_id imu_topic",
        "",
        "one cloud with all returns on points_topic, x y z intensity ring time; IMU on NAME/imu in the "
        "sensor's "
        "frame"},
       {"range_min range_max", "", "without range_filter_handling they limit nothing", "*"},
       {"range_filter_handling", "",
        "merged and virtual scans have range_min and range_max, per source too (source_settings)", "0"},
       {"min_intensity", "filter",
        "filter: {intensity_min: ...}; a beam whose return is weaker is NaN (theirs: +inf, which says free)",
        "", as_intensity_filter},
       {"use_binary_protocol sopas_cola_binary", "", "found out by asking the device", "*"},
       {"timelimit read_timeout_millisec_default read_timeout_millisec_startup "
        "read_timeout_millisec_kill_node "
        "message_monitoring_enabled udp_timeout_ms udp_timeout_ms_initial sopas_timeout_ms auto_reboot",
        "", "silence is told within 1 s, and connections are made again without end", "*"},
       {"sw_pll_only_publish use_generation_timestamp tick_to_timestamp_mode", "",
        "stamps follow the device's clock all the time, counted in the host's (clock: smooth)", "true 0"},
       {"start_services start_sopas_service", "",
        "there are no services: what the device says is on /diagnostics"},
       {"ros_qos udp_input_fifolength msgpack_output_fifolength", "",
        "queues are bounded, and what is lost in them is counted", "*"},
       {"check_udp_receiver_ip check_udp_receiver_port", "",
        "an address that this host does not have is told by `lidard check` and on /diagnostics", "*"},
       {"udp_sender", "", "packets are taken from ip_address", "*"},
       {"scandataformat", "", "Compact and MSGPACK are both read, without being told which", "*"},
       {"sopas_tcp_port", "", "2111", "2111"},
       {"send_sopas_start_stop_cmd send_udp_start send_udp_start_string host_read_filtersettings "
        "initialize_scanner "
        "load_application_default",
        "", "nothing has to be sent to a device that streams; it is asked only if udp_receiver_ip is set",
        "*"},
       {"imu_enable imu_udp_port imu_latency_microsec", "",
        "an IMU's data are read where the device sends them (UDP 7503; MRS1000: beside its scans), and "
        "stamped "
        "like its scans"},
       {"verbose_level measure_timing export_csv export_udp_msg logfolder nodename publish_datagram "
        "subscribe_datagram device_number segment_count",
        "", "`lidard status`, `lidard record` and `lidard decode` do such things", "*"},
       {"msgpack_validator_*", "", "each telegram is checked, and what is missing is counted", "*"},
       {"time_increment", "", "the device says how long its scan takes", "*"},
       {"expected_frequency_tolerance", "", "/diagnostics compares with what the device promises", "*"},
       {"intensity_resolution_16bit ang_res scan_freq scan_cfg_list_entry "
        "scandatacfg_timingflag "
        "scandatacfg_azimuth_table encoder_mode active_field_set field_set_selection_method "
        "performanceprofilenumber "
        "lfp_meanfilter lfp_medianfilter host_set_FREchoFilter host_LFPangleRangeFilter "
        "host_set_LFPangleRangeFilter "
        "host_LFPintervalFilter host_set_LFPintervalFilter host_LFPlayerFilter host_set_LFPlayerFilter "
        "active_echos "
        "glare_detection_sens lmd_scandatascalefactor ntp_server_address new_IP_address locationName",
        "", device_setting, "-1"},
       {"nav_* topic_radar topic_cloud_radar_* transmit_raw_targets transmit_objects tracking_mode "
        "slam_bundle "
        "slam_echo start_angle end_angle scan_frequency angular_resolution_type layer_range_reduction "
        "ignore_near_range sensitivity_control flexres_* contour_point_density min_object_age "
        "max_prediction_age "
        "sync_angle_offset",
        "", other_device}},
      {{"scan scan_fullframe", "sensor_msgs/LaserScan", "the same: scan_topic"},
       {"scan_segment", "sensor_msgs/LaserScan", "none: scans are published whole"},
       {"cloud cloud_*", "sensor_msgs/PointCloud2",
        "the same: points_topic, or cloud_destination_topic of a planar one; x y z intensity ring time"},
       {"imu", "sensor_msgs/Imu", "NAME/imu"},
       {"encoder", "sick_scan_xd/Encoder",
        "NAME/encoder as diagnostic_msgs/DiagnosticArray; its type is not carried here"},
       {"lferec lidinputstate lidoutputstate", "sick_scan_xd/LFErecMsg, LIDinputstateMsg, LIDoutputstateMsg",
        "NAME/lferec, ... as diagnostic_msgs/DiagnosticArray, with publish_states: true; their types "
        "are not carried here"},
       {"marker", "visualization_msgs/MarkerArray", "none: fields are drawn by nobody"},
       {"ColaMsg ECRChangeArr SCdevicestate SCreboot SCsoftreset GetContaminationResult FieldSetRead "
        "FieldSetWrite",
        "services", "none: nobody commands the device over ROS"},
       {"diagnostics", "diagnostic_msgs/DiagnosticArray", "the same topic, more in it"}}};
  return package;
}

DropinSetup sick_scan_setup(const NodeParameters& parameters) {
  DropinSetup setup;
  ParameterReader reader(parameters);
  const std::string scanner_type = reader.text("scanner_type", "");
  const ScannerType& type = type_of(scanner_type);
  const bool is_165 = type.ours == "sick_multiscan136" && reader.text("layer_lookup_table_id", "0") == "1";
  const Model& model = *find_model(is_165 ? "sick_multiscan165" : type.ours);
  KeyMap sensor{{"model", std::string(model.name)}, {"ip_address", reader.text("hostname", "192.168.0.1")}};
  const std::string port = reader.text("port", "");
  if (type.other_port)
    setup.remarks.emplace_back("port is not taken over: an LRS4000 is read from its port for measured data");
  else if (model.transport == Transport::tcp && !port.empty())
    sensor.emplace_back("ip_port", port);
  std::string frame = reader.text("frame_id", reader.text("publish_frame_id", "cloud"));
  if (!frame.empty() && frame.front() == '/') frame.erase(0, 1);
  if (frame.empty()) frame = "cloud";
  place_sensor(reader, frame, setup);
  sensor.emplace_back("frame_id", frame);
  const std::string scan =
      reader.text("publish_laserscan_fullframe_topic", reader.text("laserscan_topic", "scan"));
  sensor.emplace_back("scan_topic", scan);
  const bool is_planar = model.kind == FrameKind::scan;
  // Clouds of a picoScan have topics of their own kind (custom_pointclouds).
  const bool has_usual_cloud = !is_planar || model.transport == Transport::tcp;
  const std::string cloud = reader.text("cloud_topic", has_usual_cloud ? "cloud" : "");
  if (!is_planar) sensor.emplace_back("points_topic", cloud);
  reader.move(moved_sick_scan(), sensor, setup);
  const bool listens =
      std::any_of(sensor.begin(), sensor.end(), [](const auto& one) { return one.first == "listen_only"; });
  // sick_scan_xd sets each device up as its parameters say.
  if (!listens) sensor.emplace_back("allow_write", true);
  pair_login(sensor, setup);
  drop_misfits(model, sensor, setup);
  setup.keys = {{"sensors", KeyMap{{"scanner", std::move(sensor)}}}};
  if (is_planar && !cloud.empty())
    setup.keys.emplace_back("merged_scans",
                            KeyMap{{"scanner_cloud", KeyMap{{"laserscan_topics", KeyList{"scanner"}},
                                                            {"destination_frame", frame},
                                                            {"cloud_destination_topic", cloud}}}});
  reader.remark_on_rest(setup.warnings);
  return setup;
}

}  // namespace lidard
