// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// All keys of the configuration, and where each can be put.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "daemon/commands/commands.h"

namespace lidard::test {

/// What `lidard keys --json` prints.
inline const nlohmann::json& all_keys() {
  static const nlohmann::json keys = [] {
    std::ostringstream out;
    EXPECT_EQ(run_keys(KeysFormat::json, out), 0);
    return nlohmann::json::parse(out.str());
  }();
  return keys;
}

inline const std::string vehicle_with =
    "vehicle: {base_frame: base, footprint: [[-1, -1], [1, -1], [0, 1]], ";
inline const std::string two_sensors =
    "sensors: {a: {topic: /a}, b: {model: velodyne_vlp16, ip_address: 10.0.0.1}, c: {topic: /c}}\n";
inline const std::string merged =
    two_sensors + "merged_scans: {m: {laserscan_topics: [a, c], profile: strict, ";
inline const std::string cut =
    two_sensors +
    "virtual_scans: {v: {cloud_topic: b, virtual_laser_scan: [x, y], profile: strict, poses: "
    "{x: {xyz: [0, 0, 1]}}, ";

/// The texts into which a key of a section can be put, each with `@` in its place.
inline std::vector<std::string> places_of(const std::string& section) {
  if (section == "vehicle") return {vehicle_with + "@}\n", "vehicle: {odometry_topic: /odom, @}\n"};
  if (section == "sensors.NAME") {
    std::vector<std::string> all = {"sensors: {s: {topic: /t, @}}\n", "sensors: {s: {@}}\n"};
    for (const char* model : {"velodyne_vlp16", "velodyne_vls128", "sick_microscan3", "sick_lms1xx",
                              "sick_picoscan150", "hokuyo_utm_30lx_ew"})
      all.push_back("sensors: {s: {model: " + std::string(model) + ", ip_address: 10.0.0.7, @}}\n");
    return all;
  }
  if (section == "sensors.NAME.control")
    return {"sensors: {s: {model: velodyne_vlp16, ip_address: 10.0.0.7, control: {@}}}\n",
            "sensors: {s: {model: velodyne_vls128, ip_address: 10.0.0.7, control: {allow_write: true, @}}}\n",
            "sensors: {s: {model: sick_microscan3, ip_address: 10.0.0.7, control: {@}}}\n"};
  if (section == "sensors.NAME.filter")
    return {"sensors: {s: {model: velodyne_vlp16, filter: {@}}}\n",
            "sensors: {s: {model: sick_microscan3, ip_address: 10.0.0.1, filter: {@}}}\n"};
  if (section == "merged_scans.NAME")
    return {merged + "@}}\n", two_sensors + "merged_scans: {m: {laserscan_topics: [a], @}}\n"};
  if (section == "merged_scans.NAME.source_settings.SOURCE")
    return {merged + "source_settings: {a: {@}}}}\n"};
  if (section == "merged_clouds.NAME") return {two_sensors + "merged_clouds: {m: {sources: [b], @}}\n"};
  if (section == "virtual_scans.NAME")
    return {cut + "@}}\n",
            two_sensors + "virtual_scans: {v: {cloud_topic: b, virtual_laser_scan: [b], @}}\n"};
  if (section == "virtual_scans.NAME.ground")
    return {cut + "ground: {@}}}\n", cut + "ground: {model: slope, @}}}\n"};
  if (section == "blackbox") return {"sensors: {s: {model: velodyne_vlp16}}\nblackbox: {@}\n"};
  ADD_FAILURE() << "no place for keys of " << section;
  return {};
}

/// A place with a key in it.
inline std::string with(std::string place, const std::string& what) {
  return place.replace(place.find('@'), 1, what);
}

}  // namespace lidard::test
