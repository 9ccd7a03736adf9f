// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/cloud_keys.h"

namespace lidard {

using namespace keys;
using D = DriverConfig;

constexpr double farthest_m = 1000;

Keys<D> revolution_keys() {
  const Words<FrameCut> cuts{{"angle", FrameCut::angle}, {"view", FrameCut::view}, {"time", FrameCut::time}};
  return {word("frame_cut", &D::frame_cut, cuts,
               "where a frame ends: at cut_angle, in the sector that the sensor leaves out, or by time")
              .of_form("one of angle, view, time"),
          angle("cut_angle", &D::cut_angle, -two_pi, two_pi, "as the sensor counts azimuth")
              .shown_if([](const D& driver) { return driver.frame_cut != FrameCut::time; }),
          number("frame_duration", &D::frame_duration, 0.001, 10, "s", "with frame_cut: time")
              .shown_if([](const D& driver) { return driver.frame_cut == FrameCut::time; }),
          number("min_range", &D::min_range, 0, farthest_m, "m", "nearer returns are left out"),
          number("max_range", &D::max_range, 0, farthest_m, "m", "farther returns are left out; 0: no limit"),
          angle("view_direction", &D::view_direction, -two_pi, two_pi,
                "middle of the sector that is kept, counter-clockwise from the front"),
          angle("view_width", &D::view_width, 0, two_pi, "width of that sector")};
}

}  // namespace lidard
