// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The filter that needs PCL, as a module that is loaded on demand. Separate from the module for PCD files,
// which depends on VTK.
#include <pcl/filters/radius_outlier_removal.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <algorithm>

#include "core/frames/frame_filter.h"

/// A lidard::FindInliers, found by name in the module.
extern "C" void lidard_find_inliers(const lidard::CloudPoint* points, std::size_t count, double radius,
                                    int neighbours, std::uint8_t* inliers) {
  std::fill(inliers, inliers + count, std::uint8_t{0});
  if (count == 0) return;
  const auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  cloud->reserve(count);
  for (std::size_t i = 0; i < count; ++i) cloud->emplace_back(points[i].x, points[i].y, points[i].z);
  pcl::RadiusOutlierRemoval<pcl::PointXYZ> removal;
  removal.setRadiusSearch(radius);
  removal.setMinNeighborsInRadius(neighbours);
  removal.setInputCloud(cloud);
  pcl::Indices chosen;
  removal.filter(chosen);
  for (const auto i : chosen) inliers[i] = 1;
}
