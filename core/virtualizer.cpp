// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/virtualizer.h"

namespace lidard {

void Virtualizer::project(const Cloud& cloud, const Pose& virtual_from_cloud, PlanarScan& scan) {
  flattener_.begin(scan, true);
  scan.stamp = cloud.stamp;
  if (scan.scan_time == 0 && cloud.end > cloud.stamp) {
    scan.scan_time = static_cast<float>(seconds(cloud.end - cloud.stamp));
  }
  const Eigen::Matrix3d rotation = virtual_from_cloud.linear();
  const Eigen::Vector3d translation = virtual_from_cloud.translation();
  const CloudPoint* points = cloud.points();
  const std::size_t n = cloud.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d p(static_cast<double>(points[i].x), static_cast<double>(points[i].y),
                            static_cast<double>(points[i].z));
    flattener_.add(rotation * p + translation, points[i].intensity);
  }
}

}  // namespace lidard
