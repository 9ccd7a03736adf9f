// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace lidard {

/// A number of a merged or virtual scan that nodes of ira_laser_tools let change at run time.
struct GridLimit {
  std::string_view name;
  double min, max;
  double preset;  ///< their default
};

/// ira_laser_tools 1.0.7, cfg/laserscan_multi_merger.cfg. Its virtualizer ends range_max at 50 m, which users
/// complained about (ira_laser_tools issue 10); 1000 m holds for both here.
constexpr GridLimit grid_limits[]{{"angle_min", -3.14159265358979323846, 3.14159265358979323846, -2.36},
                                  {"angle_max", -3.14159265358979323846, 3.14159265358979323846, 2.36},
                                  {"angle_increment", 0, 3.14159265358979323846, 0.0058},
                                  {"time_increment", 0, 1, 0},
                                  {"scan_time", 0, 1, 0.0333333},
                                  {"range_min", 0, 50, 0.45},
                                  {"range_max", 0, 1000, 25}};

constexpr const GridLimit* grid_limit(std::string_view name) {
  for (const GridLimit& limit : grid_limits) {
    if (limit.name == name) return &limit;
  }
  return nullptr;
}

}  // namespace lidard
