// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace lidard::test {

/// One point of a PCD file that tier4/nebula wrote of a Velodyne.
struct NebulaPoint {
  float x, y, z;  ///< m
  int intensity, return_type, channel;
  double azimuth_deg, elevation_deg;
  double distance_m;
  unsigned time_stamp_ns;  ///< in these files: after the packet's stamp
};

/// The points of a PCD file of those ten fields, DATA binary. Throws std::runtime_error where it is another.
std::vector<NebulaPoint> read_nebula_pcd(const std::string& path);

}  // namespace lidard::test
