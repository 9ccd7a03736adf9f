// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/empty_beam.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lidard {
namespace {

TEST(EmptyBeam, ValuesLieOutsideTheRangesThatAreMeasured) {
  constexpr float infinite = std::numeric_limits<float>::infinity();
  EXPECT_EQ(value_of(EmptyBeam::inf, 30), infinite);
  EXPECT_EQ(value_of(EmptyBeam::minus_inf, 30), -infinite);
  EXPECT_EQ(value_of(EmptyBeam::range_max_plus_one, 30), 31.0F);
  EXPECT_EQ(value_of(EmptyBeam::zero, 30), 0.0F);
  EXPECT_TRUE(std::isnan(value_of(EmptyBeam::nan, 30)));
}

}  // namespace
}  // namespace lidard
