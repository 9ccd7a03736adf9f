// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace lidard {

/// A key of former versions.
struct RemovedKey {
  std::string_view key;      ///< the end of its path, from a dot on
  std::string_view instead;  ///< what to do now, as the end of "expected …"
};

constexpr RemovedKey removed_keys[] = {
    {".frame_cut", "no such key: frames are revolutions; cut_angle puts the cut into the sector that a field of "
                   "view leaves out"},
    {".frame_duration", "no such key: frames are revolutions"},
    {".publish_confidence", "no such key: clouds have the fields of velodyne_pointcloud"},
    {".publish_echo", "no such key: `lidard decode` writes the number of each return"},
    {".control.laser", "no such key: switch the laser in the sensor's web page"},
    {".control.phase_lock", "no such key: set the phase lock in the sensor's web page"},
    {".control.save", "no such key: what a sensor forgets is written again when it comes back; save settings for "
                      "good in its web page"},
    {".control.period", "no such key: the sensor is read every 10 s"},
};

/// What to do instead of a key of former versions, by its path ("sensors.roof.control.save"); empty: there was
/// none of this name.
constexpr std::string_view instead_of_removed(std::string_view path) {
  for (const RemovedKey& removed : removed_keys) {
    const std::size_t size = removed.key.size();
    if (path.size() > size && path.substr(path.size() - size) == removed.key) return removed.instead;
  }
  return {};
}

}  // namespace lidard
