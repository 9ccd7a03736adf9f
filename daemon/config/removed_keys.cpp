// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fnmatch.h>

#include "daemon/config/yaml_reader.h"

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
    {"sensors.*.control.save", "no such key: settings are written again when the sensor comes back"},
    {"sensors.*.control.period", "no such key: the sensor is read every 10 s"},
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

}  // namespace

std::string_view instead_of(const std::string& path) {
  for (const RemovedKey& key : removed_keys) {
    if (::fnmatch(key.path, path.c_str(), 0) == 0) return key.instead;
  }
  return {};
}

}  // namespace lidard
