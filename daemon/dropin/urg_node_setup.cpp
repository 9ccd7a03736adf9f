// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/moving.h"

namespace lidard {

DropinSetup urg_node_setup(const NodeParameters& parameters) {
  Translation node(parameters);
  KeyMap sensor{{"model", "hokuyo_scip"}};
  node.setup.remarks.emplace_back(
      "model hokuyo_scip asks the scanner what it is; a UAM-05LP, which speaks another protocol, is "
      "hokuyo_uam_05lp");
  std::string prefix = node.text("tf_prefix", "");
  while (!prefix.empty() && prefix.front() == '/') prefix.erase(0, 1);
  const std::string frame = node.text("frame_id", node.text("laser_frame_id", "laser"));
  // As tf::resolve(): a frame with a leading slash has no prefix.
  const bool is_absolute = prefix.empty() || frame.rfind('/', 0) == 0;
  sensor.emplace_back("frame_id", as_frame(is_absolute ? frame : prefix + "/" + frame));
  for (const char* name : {"angle_min", "angle_max"}) {
    if (const auto value = node.find(name)) sensor.emplace_back(name, copied(*value));
  }
  node.move("urg_node", sensor);
  if (find_key(sensor, "ip_address") == nullptr) {
    node.warn(
        "no ip_address: urg_node read a serial port, which lidard does not; 192.168.0.10 stands in for it");
    sensor.emplace_back("ip_address", "192.168.0.10");
  }
  if (find_key(sensor, "calibrate_time") == nullptr) sensor.emplace_back("calibrate_time", false);
  sensor.emplace_back("scan_topic", "scan");
  node.setup.keys.sensors = {{"urg_node", std::move(sensor)}};
  return node.finish();
}

}  // namespace lidard
