// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// All that needs PCL, as a module that is loaded when a PCD file is requested: Debian's PCL brings VTK with
// it, 50 libraries that a daemon on a vehicle has no use for.
#include "daemon/files/pcl_module.h"

#include <pcl/io/pcd_io.h>
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

extern "C" bool lidard_write_pcd(const char* path, const lidard::CloudPoint* points, std::size_t count) {
  pcl::PointCloud<lidard::PointXYZIRT> cloud;
  cloud.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const lidard::CloudPoint p = points[i];
    lidard::PointXYZIRT point{};
    point.x = p.x, point.y = p.y, point.z = p.z;
    point.intensity = p.intensity, point.ring = p.ring, point.time = p.time;
    cloud.push_back(point);
  }
  try {
    return pcl::PCDWriter().writeBinaryCompressed(path, cloud) == 0;
  } catch (const std::exception&) {
    return false;
  }
}
