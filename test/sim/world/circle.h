// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/frames/scan_grid.h"

namespace lidard::test {

/// The grid of an output that looks all around; ranges in m.
inline ScanGrid full_circle(std::size_t beams, double range_max = 50,
                            double range_min = ScanGridSpec().range_min) {
  ScanGridSpec spec;
  spec.beams = beams;
  spec.range_min = range_min;
  spec.range_max = range_max;
  return make_grid(spec).value();
}

}  // namespace lidard::test
