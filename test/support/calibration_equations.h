// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "drivers/velodyne/calibration.h"

namespace lidard::test {

struct PlacedPoint {
  double x, y, z, intensity;
};

/// The equations of velodyne_pointcloud's rawdata.cc, step by step as they stand there, in double.
/// `two_point` says whether the near corrections are enabled; azimuth in rad.
PlacedPoint place_like_ros_drivers(const LaserCalibration& laser, bool two_point, double step_m, int count,
                                   int raw_intensity, double azimuth);

/// Those of 63-HDL64ES3 Rev K, appendix F, as the manual writes them: in cm, the offset of the beam's origin
/// in z.
PlacedPoint place_like_manual(const LaserCalibration& laser, bool two_point, double step_m, int count,
                              int raw_intensity, double azimuth);

}  // namespace lidard::test
