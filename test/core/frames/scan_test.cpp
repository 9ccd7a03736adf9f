// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/scan.h"

#include <gtest/gtest.h>

TEST(PlanarScan, FreshScanHasNoViolationOnceItHasAnglesAndLimits) {
  lidard::PlanarScan scan;
  scan.reset(3);
  scan.set_angles(-1.0F, 0.5F);
  scan.range_max = 10;
  EXPECT_EQ(lidard::violation(scan), nullptr);
  scan.ranges[1] = 11;
  EXPECT_NE(lidard::violation(scan), nullptr);
}
