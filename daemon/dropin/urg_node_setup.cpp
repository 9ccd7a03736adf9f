// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/moving.h"

namespace lidard {

const MovedPackage& moved_urg_node() {
  static const MovedPackage package{
      "urg_node",
      "urg_node urg_node2",
      "src/urg_node_driver.cpp, cfg/URG.cfg, launch/urg_lidar.launch (melodic-devel), and the parameter "
      "files of its "
      "ROS 2 branch",
      {{"ip_address laser_ip_address", "ip_address",
        "as it is; empty, a scanner at a serial port, is 192.168.0.10, the address that a Hokuyo leaves the "
        "factory "
        "with",
        "", copied},
       {"ip_port", "ip_port", "as it is", "", copied},
       {"frame_id laser_frame_id", "frame_id", "as it is, below tf_prefix; without it laser"},
       {"tf_prefix", "frame_id", "stands before it"},
       {"time_offset", "time_offset",
        "s, as it is; an offset that made up for the latency of urg_node is to be taken out: here the "
        "scanner's own "
        "clock says when a scan began",
        "", copied},
       {"angle_min angle_max", "angle_min angle_max", "rad, as they are"},
       {"cluster", "cluster", "as it is", "", copied},
       {"skip", "skip", "as it is", "", copied},
       {"calibrate_time", "calibrate_time", "as it is; without it false", "", copied},
       {"publish_intensity", "publish_intensity", "as it is", "", copied},
       {"publish_multiecho", "publish_multiecho", "as it is", "", copied},
       {"serial_port serial_baud", "",
        "there are no serial ports here: connect the scanner over Ethernet, or keep urg_node and read its "
        "scans with "
        "`topic`"},
       {"synchronize_time", "", "clock: smooth, the default, follows the scanner's clock all the time",
        "false"},
       {"error_limit error_reset_period", "",
        "the connection is made again whenever it fails, without end, and each time is counted", "*"},
       {"diagnostics_tolerance diagnostics_window_time", "",
        "/diagnostics compares the frames of the last 10 s with what the scanner says that it sends", "*"},
       {"get_detailed_status", "", "a UAM-05LP (model: hokuyo_uam_05lp) has NAME/status with each scan",
        "false"}},
      {{"scan", "sensor_msgs/LaserScan", "the same: scan_topic"},
       {"echoes", "sensor_msgs/MultiEchoLaserScan", "NAME/echoes, with publish_multiecho: true"},
       {"first last most_intense", "sensor_msgs/LaserScan",
        "one of them: `echoes` of a merged scan; all of them are in NAME/echoes"},
       {"laser_status", "urg_node/Status",
        "NAME/status as diagnostic_msgs/DiagnosticArray (UAM-05LP), and not in this type: three of its seven "
        "values are the last stop's, which urg_node asks for by another command (DL00)"},
       {"update_laser_status", "std_srvs/Trigger", "not needed: the status comes with each scan"},
       {"diagnostics", "diagnostic_msgs/DiagnosticArray", "the same topic, more in it"}}};
  return package;
}

DropinSetup urg_node_setup(const NodeParameters& parameters) {
  DropinSetup setup;
  ParameterReader reader(parameters);
  KeyMap sensor{{"model", "hokuyo_scip"}};
  setup.remarks.emplace_back(
      "model hokuyo_scip asks the scanner what it is; a UAM-05LP, which speaks another protocol, is "
      "hokuyo_uam_05lp");
  std::string prefix = reader.text("tf_prefix", "");
  while (!prefix.empty() && prefix.front() == '/') prefix.erase(0, 1);
  const std::string frame = reader.text("frame_id", reader.text("laser_frame_id", "laser"));
  sensor.emplace_back("frame_id", as_frame(prefix.empty() ? frame : prefix + "/" + frame));
  for (const char* name : {"angle_min", "angle_max"}) {
    if (const auto value = reader.find(name)) sensor.emplace_back(name, copied(*value));
  }
  reader.move(moved_urg_node(), sensor, setup);
  const auto has = [&](std::string_view key) {
    for (const auto& one : sensor) {
      if (one.first == key) return true;
    }
    return false;
  };
  if (!has("ip_address")) {
    setup.warnings.emplace_back(
        "no ip_address: urg_node read a serial port, which lidard does not; 192.168.0.10 stands in for it");
    sensor.emplace_back("ip_address", "192.168.0.10");
  }
  if (!has("calibrate_time")) sensor.emplace_back("calibrate_time", false);
  sensor.emplace_back("scan_topic", "scan");
  setup.keys = {{"sensors", KeyMap{{"urg_node", std::move(sensor)}}}};
  reader.remark_on_rest(setup.warnings);
  return setup;
}

}  // namespace lidard
