// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/moving.h"
#include "drivers/address.h"

namespace lidard {

DropinSetup safety_scanners_setup(const NodeParameters& parameters) {
  Translation node(parameters);
  KeyMap sensor{{"model", "sick_microscan3"}};
  node.warn(
      "sick_safetyscanners does not distinguish microScan3, nanoScan3 and outdoorScan3; change "
      "model where it is another one: limits of ranges differ");
  const std::string host = node.text("host_ip", "192.168.1.9");
  sensor.emplace_back("ip_address", node.text("sensor_ip", "192.168.1.10"));
  sensor.emplace_back("udp_receiver_ip", host);
  sensor.emplace_back("frame_id", as_frame(node.text("frame_id", "scan")));
  if (const auto group = IpAddress::parse(host); group && group->is_multicast())
    sensor.emplace_back("multicast_group", host);
  sensor.emplace_back("allow_write", true);
  const double start = node.number("angle_start", 0), end = node.number("angle_end", 0);
  if (start != end) {
    sensor.emplace_back("angle_min", start);
    sensor.emplace_back("angle_max", end);
  }
  node.move("sick_safetyscanners", sensor);
  sensor.emplace_back("scan_topic", "scan");
  sensor.emplace_back("extended_scan_topic", "extended_laser_scan");
  sensor.emplace_back("output_paths_topic", "output_paths");
  node.setup.keys.sensors = {{"safety_scanner", std::move(sensor)}};
  return node.finish();
}

}  // namespace lidard
