// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pcl/point_types.h>

namespace lidard {

/// The PCL point with the fields of our clouds (m, device units, ring from below, s after the cloud's stamp).
/// PCL pads it to 32 bytes, so messages and files must be read by field names, as PCL does.
struct EIGEN_ALIGN16 PointXYZIRT {
  PCL_ADD_POINT4D
  float intensity;
  std::uint16_t ring;
  float time;
  PCL_MAKE_ALIGNED_OPERATOR_NEW
};

}  // namespace lidard

POINT_CLOUD_REGISTER_POINT_STRUCT(lidard::PointXYZIRT,
                                  (float, x, x)(float, y, y)(float, z, z)(float, intensity,
                                                                          intensity)(std::uint16_t, ring,
                                                                                     ring)(float, time, time))
