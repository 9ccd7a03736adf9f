// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/sim/world/geometry.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace lidard::sim;
using Eigen::Vector3d;

constexpr double tolerance = 1e-12;

Ray ray(const Vector3d& from, const Vector3d& towards) { return {from, towards.normalized()}; }

TEST(RayCasting, GroundIsHitAtHeightOverSineOfTheAngleAndNeverAboveTheHorizon) {
  const double down = 15 * rad_per_deg;
  const Vector3d direction(std::cos(down), 0, -std::sin(down));
  EXPECT_NEAR(distance(Ground{0.5}, Ray{{0, 0, 2.5}, direction}), 2 / std::sin(down), tolerance);
  EXPECT_EQ(distance(Ground{0}, Ray{{0, 0, 2}, {1, 0, 0}}), no_hit);
  EXPECT_EQ(distance(Ground{0}, ray({0, 0, 2}, {1, 0, 0.1})), no_hit);
}

TEST(RayCasting, WallIsHitWithinItsLengthAndHeightFromBothSides) {
  const Wall wall{{5, -1}, {5, 1}, 0, 2};
  EXPECT_NEAR(distance(wall, ray({0, 0, 1}, {5, 0.9, 0})), std::hypot(5, 0.9), tolerance);
  EXPECT_NEAR(distance(wall, ray({8, 0, 1}, {-1, 0, 0})), 3, tolerance);
  EXPECT_EQ(distance(wall, ray({0, 0, 1}, {5, 1.1, 0})), no_hit) << "past its end";
  EXPECT_EQ(distance(wall, ray({0, 0, 1}, {5, 0, 1.1})), no_hit) << "above it";
  EXPECT_EQ(distance(wall, ray({0, 0, 1}, {-1, 0, 0})), no_hit) << "behind the ray";
  EXPECT_EQ(distance(wall, ray({0, 0, 1}, {0, 1, 0})), no_hit) << "along it";
}

TEST(RayCasting, BoxIsHitAtItsNearFaceFromOutsideAndAtItsFarFaceFromInside) {
  const Box box{{2, 4, 6}};
  EXPECT_NEAR(distance(box, ray({-10, 0, 0}, {1, 0, 0})), 9, tolerance);
  EXPECT_NEAR(distance(box, ray({0, 0, 0}, {0, 1, 0})), 2, tolerance);
  EXPECT_NEAR(distance(box, ray({0, 0, 10}, {0, 0, -1})), 7, tolerance);
  EXPECT_EQ(distance(box, ray({-10, 2.1, 0}, {1, 0, 0})), no_hit);
  EXPECT_EQ(distance(box, ray({-10, 0, 0}, {-1, 0, 0})), no_hit);
}

TEST(RayCasting, TurnedBoxShowsItsCornerNearer) {
  Object object;
  object.shape = Box{{2, 2, 2}};
  object.pose = lidard::make_pose({10, 0, 0}, {0, 0, 45 * rad_per_deg});
  Hit hit;
  cast(object, Ray{}, 0, hit);
  EXPECT_NEAR(hit.distance, 10 - std::sqrt(2.0), tolerance);
}

TEST(RayCasting, CylinderIsHitOnItsMantleOnItsLidAndNotBesideIt) {
  const Cylinder cylinder{0.5, 2};
  EXPECT_NEAR(distance(cylinder, ray({-10, 0, 0}, {1, 0, 0})), 9.5, tolerance);
  EXPECT_NEAR(distance(cylinder, ray({-10, 0.3, 0}, {1, 0, 0})), 10 - 0.4, tolerance);
  EXPECT_NEAR(distance(cylinder, ray({0.2, 0, 5}, {0, 0, -1})), 4, tolerance);
  EXPECT_NEAR(distance(cylinder, ray({-3, 0, 4}, {1, 0, -1})), 3 * std::sqrt(2.0), tolerance) << "lid";
  EXPECT_EQ(distance(cylinder, ray({-10, 0.6, 0}, {1, 0, 0})), no_hit);
  EXPECT_EQ(distance(cylinder, ray({-10, 0, 1.1}, {1, 0, 0})), no_hit);
  EXPECT_EQ(distance(cylinder, ray({0.6, 0, 5}, {0, 0, -1})), no_hit);
}

TEST(RayCasting, MovingObjectIsHitWhereItIsAtTheMomentOfTheFiring) {
  Object object;
  object.shape = Cylinder{1, 2};
  object.waypoints = {{0, {10, 0, 0}, 0}, {2, {14, 0, 0}, 0}};
  for (const auto& [time, expected] :
       {std::pair{-1.0, 9.0}, {0.0, 9.0}, {0.5, 10.0}, {2.0, 13.0}, {9.0, 13.0}}) {
    Hit hit;
    cast(object, Ray{}, time, hit);
    EXPECT_NEAR(hit.distance, expected, tolerance) << time;
  }
}

TEST(RayCasting, NearestOfSeveralObjectsWinsWithItsReflectivity) {
  Object near;
  near.shape = Wall{{3, -1}, {3, 1}, -1, 1};
  near.reflectivity = 0.9;
  Object far = near;
  far.shape = Wall{{4, -1}, {4, 1}, -1, 1};
  far.reflectivity = 0.1;
  Hit hit;
  cast(far, Ray{}, 0, hit);
  cast(near, Ray{}, 0, hit);
  cast(far, Ray{}, 0, hit);
  EXPECT_NEAR(hit.distance, 3, tolerance);
  EXPECT_EQ(hit.reflectivity, 0.9);
}

}  // namespace
