// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Keys that are no longer known, and keys of other drivers.
#include <fnmatch.h>

#include <algorithm>

#include "daemon/config/values.h"

namespace lidard {
namespace {

struct RemovedKey {
  const char* path;  ///< with * for names
  const char* instead;
};

constexpr RemovedKey removed_keys[] = {
    {"sensors.*.frame_cut", "cut_angle: a frame is a revolution that ends there"},
    {"sensors.*.frame_duration", "no such key: a frame is a revolution"},
    {"sensors.*.publish_confidence", "no such key: clouds have the fields x, y, z, intensity, ring and time"},
    {"sensors.*.publish_echo", "no such key: the returns of a firing have the same ring and time"},
    {"sensors.*.control.fov", "fov_start_deg and fov_end_deg"},
    {"sensors.*.control.host", "host_address, host_port, host_telemetry_port"},
    {"sensors.*.control.laser", "no such key: switch the laser in the sensor's web page"},
    {"sensors.*.control.phase_lock", "no such key: set the phase lock in the sensor's web page"},
    {"sensors.*.control.read",
     "no such key: the settings given in control are compared by themselves; the sensor's state stands in "
     "its web page"},
    {"sensors.*.control.save", "no such key: settings are written again when the sensor comes back"},
    {"sensors.*.control.period", "no such key: settings are compared when the sensor appears"},
    {"sensors.*.filter.intensity_max", "no such key: intensity_min removes weak returns"},
    {"merged_scans.*.source_settings.*.intensity_*",
     "no such key: a limit that is set in the scanner, if it has one"},
    {"merged_scans.*.source_settings.*.range_noise", "range_noise of the merged scan, for all sources"},
    {"merged_scans.*.source_settings.*.echoes", "echoes of the merged scan, for all sources"},
    {"merged_scans.*.source_settings.*.veil_filter", "veil_filter of the merged scan, for all sources"},
    {"merged_scans.*.publish_when_empty",
     "no such key: without any source there is no output, and /diagnostics says why"},
    {"merged_scans.*.max_age", "deadline: a sweep is used until the next one of its source is overdue by it"},
    {"merged_scans.*.fuse", "no such key: of several surfaces the nearest one counts"},
    {"merged_scans.*.conflicts", "no such key: every return counts until its source sends a newer sweep"},
    {"merged_scans.*.veil_cross_check", "veil_filter, which finds mixed pixels in each scan"},
    {"merged_scans.*.intensity",
     "no such key: a merged scan has intensities where all its sources have them"},
    {"merged_scans.*.missing_intensity",
     "no such key: a merged scan has intensities where all its sources have them"},
    {"blackbox.on_error", "no such key: a capture is written when an item of /diagnostics goes to ERROR"},
    {"virtual_scans.*.ground.steepest", "no such key: ground of model slope rises by 0.15 m per m at most"},
    {"virtual_scans.*.free_required", "range_max: a beam is free where its way is observed as far as that"},
    {"virtual_scans.*.keep_ground", "ground: none"},
    {"virtual_scans.*.range_noise", "no such key: 0.02 m, that of the lidars that give clouds"},
};

/// What other drivers call a key, with | between the names.
struct Synonym {
  const char *section, *called, *ours;
};

constexpr Synonym synonyms[] = {
    {"", "sensor|lidars|lidar|scanners|devices", "sensors"},
    {"vehicle.", "frame|frame_id|robot_frame|robot_base_frame|base_link", "base_frame"},
    {"sensors.*.", "type|lidar_type|sensor_type|sensor_model|scanner_type|device_type|product", "model"},
    {"sensors.*.", "hostname|host|ip|address|device_ip|sensor_ip|scanner_ip|lidar_ip", "ip_address"},
    {"sensors.*.", "port|udp_port|data_port|tcp_port|msop_port|host_port|lidar_port", "ip_port"},
    {"sensors.*.", "host_ip|host_address|receiver_ip|destination_ip|pc_ip", "udp_receiver_ip (SICK)"},
    {"sensors.*.", "gps_port|position_port|gnss_port|difop_port", "telemetry_port"},
    {"sensors.*.", "multicast_ip|multicast_address|multicast_addr|group_ip", "multicast_group"},
    {"sensors.*.", "frame|frame_name|laser_frame_id|sensor_frame|laser_frame", "frame_id"},
    {"sensors.*.", "position|transform|xyz|translation|extrinsics|mount|rpy|rpy_deg",
     "pose: {xyz: [x, y, z], rpy_deg: [roll, pitch, yaw]}"},
    {"sensors.*.", "rpm|return_mode", "control: {rpm: …, returns: …} of a Velodyne, or no such key"},
    {"sensors.*.", "min_ang|min_angle|angle_start|start_angle", "angle_min"},
    {"sensors.*.", "max_ang|max_angle|angle_end|end_angle", "angle_max"},
    {"sensors.*.", "calibration_file|correction_file|calib_file", "calibration"},
    {"sensors.*.", "pcap|pcap_file", "no such key; `lidard replay --pcap FILE` plays captures"},
    {"merged_scans.*.", "sources|topics|input_topics|scan_topics|scans|sensors", "laserscan_topics"},
    {"merged_clouds.*.", "laserscan_topics|topics|input_topics|cloud_topics|sensors", "sources"},
    {"merged_*.*.", "frame_id|target_frame|output_frame|frame", "destination_frame"},
    {"merged_scans.*.", "topic|output_topic|scan_topic", "scan_destination_topic"},
    {"merged_clouds.*.", "topic|output_topic|cloud_topic", "destination_topic"},
    {"merged_*.*.", "frequency|publish_rate|hz", "rate"},
    {"virtual_scans.*.", "source|sources|sensor|cloud|cloud_in", "cloud_topic"},
    {"virtual_scans.*.", "frames|frame|frame_id|target_frame", "virtual_laser_scan"},
};

}  // namespace

std::string_view ours_for(const std::string& path) {
  const auto depth = [](std::string_view text) { return std::count(text.begin(), text.end(), '.'); };
  for (const Synonym& one : synonyms) {
    if (depth(one.section) != depth(path)) continue;
    const std::string pattern = std::string(one.section) + "@(" + one.called + ")";
    if (::fnmatch(pattern.c_str(), path.c_str(), FNM_EXTMATCH | FNM_CASEFOLD) == 0) return one.ours;
  }
  return {};
}

std::string_view instead_of(const std::string& path) {
  for (const RemovedKey& key : removed_keys) {
    if (::fnmatch(key.path, path.c_str(), 0) == 0) return key.instead;
  }
  return {};
}

}  // namespace lidard
