// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/moving.h"
#include "drivers/address.h"

namespace lidard {

const MovedPackage& moved_safety_scanners() {
  static const MovedPackage package{
      "sick_safetyscanners",
      "sick_safetyscanners sick_safetyscanners_node",
      "src/SickSafetyscannersRos.cpp, config/SickSafetyscannersConfiguration.cfg, "
      "launch/sick_safetyscanners.launch "
      "(1.0.9)",
      {{"sensor_ip", "ip_address", "as it is; without it 192.168.1.10"},
       {"host_ip", "udp_receiver_ip",
        "as it is, with allow_write: true, since the scanner is told to send here; without it 192.168.1.9; a "
        "multicast group becomes multicast_group too"},
       {"host_udp_port", "ip_port", "as it is; 0, any free port, is 6060", "",
        [](const std::string& value) { return value == "0" ? KeyValue() : copied(value); }},
       {"frame_id", "frame_id", "as it is; without it scan"},
       {"time_offset", "time_offset",
        "s, as it is; sick_safetyscanners stamps the arrival of the last beam, here a stamp is that of the "
        "first "
        "beam: an offset that made up for that is to be taken out",
        "", copied},
       {"angle_start angle_end", "angle_min angle_max",
        "rad, as they are; equal ones mean all beams. Beams beyond are left out here, the scanner goes on to "
        "send "
        "them"},
       {"min_intensities", "filter",
        "filter: {intensity_min: ...}; a beam whose return is weaker is NaN (theirs: +inf, which says free)",
        "", as_intensity_filter},
       {"interface_ip", "", "for a multicast group write the name of the interface into `interface`",
        "0.0.0.0"},
       {"skip", "",
        "every scan is published; set the scan interval of the output in the device (Safety Designer)", "0"},
       {"channel", "",
        "the first output channel is used; with listen_only: true any that the device is set to", "0"},
       {"channel_enabled", "", "an output that is not wanted is left out of the configuration", "true"},
       {"general_system_state derived_settings measurement_data intrusion_data application_io_data", "",
        "with publish_states: true blocks are published where the scanner sends them; with allow_write: true "
        "it is told to send those that are needed",
        "true"},
       {"use_persistent_config", "",
        "allow_write: true changes only where and how the scanner sends, and not for good; listen_only: true "
        "changes nothing",
        "false"},
       {"expected_frequency frequency_tolerance", "",
        "/diagnostics compares with what the telegrams say and the losses that they show", "*"},
       {"timestamp_min_acceptable timestamp_max_acceptable", "",
        "/diagnostics tells of late and of wrong stamps by the scanner's own clock", "*"}},
      {{"scan", "sensor_msgs/LaserScan", "the same: scan_topic; stamp of the first beam, time_increment set"},
       {"extended_laser_scan", "sick_safetyscanners/ExtendedLaserScanMsg",
        "the same: extended_scan_topic; reflektor_median is the middle of each run of reflectors, and "
        "intrusion is the flag of contamination, as there"},
       {"output_paths", "sick_safetyscanners/OutputPathsMsg",
        "the same: output_paths_topic, where the scanner sends application data (theirs: empty lists where "
        "it "
        "does not). With publish_states: true in place of the key they are on NAME/output_paths, with a "
        "stamp"},
       {"raw_data", "sick_safetyscanners/RawMicroScanDataMsg",
        "none: its parts are on scan, /diagnostics and, with publish_states: true, NAME/system_state, "
        "NAME/output_paths and NAME/intrusion; the telegrams themselves: `lidard record`"},
       {"field_data config_metadata status_overview", "services",
        "fields, cases, the checksum of the configuration and the state are read once and stand on "
        "/diagnostics "
        "(allow_write or udp_receiver_ip)"},
       {"diagnostics", "diagnostic_msgs/DiagnosticArray", "the same topic, more in it"}}};
  return package;
}

DropinSetup safety_scanners_setup(const NodeParameters& parameters) {
  DropinSetup setup;
  ParameterReader reader(parameters);
  KeyMap sensor{{"model", "sick_microscan3"}};
  setup.remarks.emplace_back(
      "sick_safetyscanners does not tell microScan3, nanoScan3 and outdoorScan3 apart; change model where it "
      "is "
      "another one: limits of ranges differ");
  const std::string host = reader.text("host_ip", "192.168.1.9");
  sensor.emplace_back("ip_address", reader.text("sensor_ip", "192.168.1.10"));
  sensor.emplace_back("udp_receiver_ip", host);
  sensor.emplace_back("frame_id", as_frame(reader.text("frame_id", "scan")));
  if (const auto group = IpAddress::parse(host); group && group->is_multicast())
    sensor.emplace_back("multicast_group", host);
  sensor.emplace_back("allow_write", true);
  const double start = reader.number("angle_start", 0), end = reader.number("angle_end", 0);
  if (start != end) {
    sensor.emplace_back("angle_min", start);
    sensor.emplace_back("angle_max", end);
  }
  reader.move(moved_safety_scanners(), sensor, setup);
  sensor.emplace_back("scan_topic", "scan");
  sensor.emplace_back("extended_scan_topic", "extended_laser_scan");
  sensor.emplace_back("output_paths_topic", "output_paths");
  setup.keys = {{"sensors", KeyMap{{"safety_scanner", std::move(sensor)}}}};
  reader.remark_on_rest(setup.warnings);
  return setup;
}

}  // namespace lidard
