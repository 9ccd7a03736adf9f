// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "core/virtual/virtualizer.h"
#include "test/core/virtual/cut_bench.h"
#include "test/core/virtual/small_lidar.h"

namespace lidard {
namespace {

using namespace test::cut;

TEST(Virtualizer, ACloudWithoutRingsIsPointsAloneAndProvesNothing) {
  Cloud cloud;
  cloud.stamp = Stamp{1'000'000'000};
  cloud.rings = 1;
  sim::Rng rng(3);
  std::vector<CloudPoint> points;
  for (int i = 0; i < 5000; ++i) {
    const double a = rng.uniform() * 2 * pi_d;
    const double z = (rng.uniform() - 0.5) * 4;
    points.push_back({static_cast<float>(9 * std::cos(a)), static_cast<float>(9 * std::sin(a)),
                      static_cast<float>(z), 1, 0, 0});
  }
  cloud.points_bytes.resize(points.size() * sizeof(CloudPoint));
  std::copy(points.begin(), points.end(), cloud.points());
  Cut cut;
  cut.band = {-0.1, 0.1};
  cut.frame = make_pose({0, 0, 2}, {0, 0, 0});
  cut.make(cloud, lidar16().pose);
  EXPECT_EQ(cut.count(cut.strict, BeamStatus::invalid), cut.grid.beams);
  EXPECT_GT(cut.count(cut.safety, BeamStatus::hit), 100U);
  EXPECT_EQ(cut.count(cut.safety, BeamStatus::none), 0U);
}

Cloud seen_alone(const sim::Object& object) {
  sim::Yard yard;
  yard.ground = false;
  yard.objects = {object};
  return seen(yard, lidar16());
}

TEST(Virtualizer, OfTwoReturnsTheLastIsTheSurface) {
  sim::Yard yard;
  yard.objects = {wall(15, -30, 15, 30)};
  // A fence at 8 m, whichever return comes first in the data.
  const Cloud far = seen(yard, lidar16());
  const Cloud near = seen_alone(wall(8, -30, 8, 30));
  for (const Cloud& dual : {test::rings::both_echoes(far, near), test::rings::both_echoes(near, far)}) {
    Cut cut;
    cut.make(dual, lidar16().pose);
    EXPECT_NEAR(cut.range(cut.strict, 0), 15, 0.01);
  }
}

TEST(Virtualizer, EarlierReturnsFromTheVehicleAreLeftOut) {
  sim::Yard yard;
  yard.objects = {wall(15, -30, 15, 30)};
  // A rail on the vehicle, through which the beams see.
  const Cloud dual = test::rings::both_echoes(seen_alone(wall(0.8, -0.5, 0.8, 0.5)), seen(yard, lidar16()));
  Cut cut;
  cut.settings.beams.early_returns = true;
  cut.frame = make_pose({0, 0, 1.9}, {0, 0, 0});
  cut.band = {-0.1, 0.1};
  cut.make(dual, lidar16().pose);
  EXPECT_NEAR(cut.range(cut.safety, 0), 0.8, 0.02);
  cut.footprint = Footprint({{-2, -1}, {1, -1}, {1, 1}, {-2, 1}});
  cut.make(dual, lidar16().pose);
  EXPECT_NEAR(cut.range(cut.safety, 0), 15, 0.02);
}

}  // namespace
}  // namespace lidard
