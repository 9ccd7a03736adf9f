// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

namespace lidard {

/// A number of a merged or virtual scan that may be changed at run time.
struct GridLimit {
  const char* name;
  const char* meaning;
  double min;
  double max;
  double preset;  ///< ira_laser_tools' default
};

/// ira_laser_tools 1.0.7, cfg/laserscan_multi_merger.cfg. Its virtualizer ends range_max at 50 m, which users
/// complained about (ira_laser_tools issue 10); 1000 m holds for both here.
constexpr std::array<GridLimit, 7> grid_limits{
    {{"angle_min", "first beam, rad", -3.14159265358979323846, 3.14159265358979323846, -2.36},
     {"angle_max", "last beam, rad", -3.14159265358979323846, 3.14159265358979323846, 2.36},
     {"angle_increment", "between beams, rad", 0, 3.14159265358979323846, 0.0058},
     {"time_increment", "between beams, s", 0, 1, 0},
     {"scan_time", "between scans, s; 0: that of the sources", 0, 1, 0.0333333},
     {"range_min", "m", 0, 50, 0.45},
     {"range_max", "m", 0, 1000, 25}}};

}  // namespace lidard
