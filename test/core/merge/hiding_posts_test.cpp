// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Posts where a merged scan may overlook them: beside the last beam of a field, before something else, at the
// seam of a full circle, and while the vehicle drives. No beam onto them is free.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "test/core/merge/merged_scene.h"

namespace lidard {
namespace {

/// One scanner in the vehicle's origin.
struct PostScene : test::MergedScene {
  PostScene() { scanners.resize(1); }
};

TEST(HidingPosts, TheStripBesideTheFirstBeamOfAVehicleThatDrovePastIsNotSeen) {
  int blocked = 0, free = 0;
  for (const double field : {180.0, 270.0}) {
    for (const double speed : {-1.0, -2.0, 2.0}) {
      for (const double y : {-1.5, -3.0, -6.0}) {
        PostScene scene;
        scene.scanners[0].field = field * degree;
        scene.scanners[0].increment = 0.5 * degree;
        const double aside = -speed * 0.1 / 2;
        scene.world.add_box({field > 200 ? aside + y : aside, y}, {0.04, 0.04}, 0);
        scene.look(speed, 0.04);
        scene.count(11);
        blocked += scene.blocked;
        free += scene.free;
      }
    }
  }
  EXPECT_GT(blocked, 50);
  EXPECT_LE(free, 4) << "grazing beams of " << blocked;
}

TEST(HidingPosts, WhatStandsBehindAPostOnTheNextBeamDoesNotFreeItsOtherHalf) {
  const std::pair<double, double> cases[] = {{0.5, 0}, {1.0, 0}, {0.5, 0.01}, {1.0, 0.01}};
  for (const auto& [increment, speed] : cases) {
    for (const double behind : {0.25, 0.4, 0.6, 1.0}) {
      for (const Eigen::Vector2d& origin :
           {Eigen::Vector2d(5, 3), Eigen::Vector2d(5, 6), Eigen::Vector2d(7, 5)}) {
        PostScene scene;
        scene.scanners[0].increment = increment * degree;
        scene.origin = origin;
        constexpr double away = 10, right = 0.01;
        const double apart = away * std::sin(increment * degree), left = -0.9 * apart;
        scene.world.add_box({away + 0.05, (right + left) / 2}, {0.05, (right - left) / 2}, 0);
        const double farther = (away + behind) / away * apart;
        scene.world.add_box({away + behind + 0.05, -1.2 * farther}, {0.05, 0.28 * farther}, 0);
        scene.look(speed);
        int overlooked = 0;
        for (std::size_t i = 0; i < scene.strict.beams; ++i) {
          const double angle = static_cast<double>(scene.strict.angle(i)),
                       truth = scene.world.cast(origin, angle);
          const Eigen::Vector2d hit = origin + truth * Eigen::Vector2d(std::cos(angle), std::sin(angle));
          if (truth > 11 || hit.x() > away + 0.101) continue;
          if (scene.strict.statuses[i] == BeamStatus::none || scene.safety.statuses[i] == BeamStatus::none)
            ++overlooked;
        }
        EXPECT_EQ(overlooked, 0) << increment << " deg, " << speed << " m/s, " << behind << " m behind, from "
                                 << origin.transpose();
      }
    }
  }
}

TEST(HidingPosts, TheSeamOfAFullCircleIsAsAnyOtherPlace) {
  for (const double increment : {0.25, 0.5, 1.0}) {
    for (const bool inclusive : {false, true}) {
      for (const double side : {4.0, -4.0}) {
        PostScene scene;
        scene.scanners[0].increment = increment * degree;
        scene.scanners[0].field = (360 - (inclusive ? 0 : increment)) * degree;
        scene.scanners[0].yaw = inclusive ? 0 : -increment / 2 * degree;
        const double apart = 10 * increment * degree;
        // From the last beam nearly to the first one, in a frame with x to the seam.
        const double from = inclusive ? 0.07 * apart : -apart - 0.01,
                     to = inclusive ? apart + 0.01 : -0.07 * apart;
        scene.world.add_box({-10.05, -(from + to) / 2}, {0.05, (to - from) / 2}, 0);
        scene.origin = {-5, -side};
        scene.range_max = 11;
        scene.look();
        scene.count(10.5);
        EXPECT_GT(scene.blocked, 0);
        EXPECT_EQ(scene.free, 0) << increment << " deg, " << (inclusive ? "inclusive" : "exclusive")
                                 << ", of " << scene.blocked;
      }
    }
  }
}

TEST(HidingPosts, PostsBesideTheWayOfAVehicleAreSeenWhole) {
  int blocked = 0, free = 0;
  for (const double increment : {0.5, 1.0}) {
    for (const double away : {6.0, 9.0}) {
      for (double azimuth = -110; azimuth <= 110; azimuth += 2.3) {
        for (const double half : {0.05, 0.08}) {
          for (const double ahead : {2.0, -2.0}) {
            PostScene scene;
            scene.scanners[0].increment = increment * degree;
            const double a = azimuth * degree;
            scene.world.add_box({away * std::cos(a), away * std::sin(a)}, {half, half}, 0);
            scene.origin = {ahead, 0};
            scene.look(1.5, 0.04);
            // Only where the scanner met the post at all.
            bool is_met = false;
            for (std::size_t i = 0; i < scene.safety.beams; ++i)
              is_met = is_met || scene.safety.statuses[i] == BeamStatus::hit;
            if (!is_met) continue;
            for (std::size_t i = 0; i < scene.strict.beams; ++i) {
              const double angle = static_cast<double>(scene.strict.angle(i));
              const Eigen::Vector2d across(-0.015 * std::sin(angle), 0.015 * std::cos(angle));
              if (scene.world.cast(scene.origin + across, angle) > 11.5 ||
                  scene.world.cast(scene.origin - across, angle) > 11.5)
                continue;
              ++blocked;
              free += scene.strict.statuses[i] == BeamStatus::none ? 1 : 0;
            }
          }
        }
      }
    }
  }
  EXPECT_GT(blocked, 2000);
  EXPECT_LE(free, blocked / 500) << "of " << blocked;
}

TEST(HidingPosts, TheEndsOfAFullCircleAreNoNeighboursWhileTheVehicleMoves) {
  int blocked = 0;
  const auto expect_none_free = [&](const Eigen::Vector2d& post, double half, const Eigen::Vector2d& origin,
                                    const sim::Pose2& speed) {
    PostScene scene;
    scene.scanners[0].increment = 0.5 * degree;
    scene.scanners[0].field = 359.5 * degree;
    scene.sweep_s = 0.1;
    scene.world.add_box(post, {half, half}, std::atan2(post.y(), post.x()));
    scene.origin = origin;
    scene.look(speed, 0);
    scene.count(11.5);
    blocked += scene.blocked;
    EXPECT_EQ(scene.free, 0) << "of " << scene.blocked << ", post at " << post.transpose() << ", from "
                             << origin.transpose();
  };
  for (const Eigen::Vector2d& origin : {Eigen::Vector2d(0, 0), Eigen::Vector2d(-1, 1.5)}) {
    for (const double turn : {-1.0, -2.0}) {
      // In the middle of what neither end saw.
      const double middle = pi_d - turn * 0.1 / 2, half = 6 * std::tan(-turn * 0.1 / 2) * 0.8;
      expect_none_free({6 * std::cos(middle), 6 * std::sin(middle)}, half, origin, {0, 0, turn});
    }
    for (const double aside : {5.0, -5.0, 2.0, -2.0})
      expect_none_free({-2, -aside * 0.05}, std::fabs(aside) * 0.035, origin, {0, aside, 0});
  }
  EXPECT_GT(blocked, 200);
  PostScene slow;
  slow.scanners[0].increment = 0.5 * degree;
  slow.scanners[0].field = 359.5 * degree;
  slow.look(0.02);
  slow.count(std::numeric_limits<double>::infinity());
  EXPECT_EQ(slow.free, 2 * slow.blocked) << "of a vehicle that hardly moves they are";
}

TEST(HidingPosts, TheFirstBeamOfAVehicleThatDrovePastAPostFreesNoneOnIt) {
  int blocked = 0, free = 0;
  for (const double increment : {0.25, 0.5, 1.0}) {
    for (const double speed : {-2.0, -5.0}) {
      for (double x = -0.02; x < 0.35; x += 0.03) {
        for (const double y : {-1.0, -2.0, -4.0}) {
          PostScene scene;
          scene.scanners[0].field = 180 * degree;
          scene.scanners[0].increment = increment * degree;
          scene.world.add_box({x, y}, {y > -1.5 ? 0.02 : 0.05, 0.05}, 0);
          scene.look(speed);
          scene.count(11);
          blocked += scene.blocked;
          free += scene.free;
        }
      }
    }
  }
  EXPECT_GT(blocked, 1000);
  EXPECT_EQ(free, 0) << "of " << blocked;
}

TEST(HidingPosts, APostThatIsPassedClosely) {
  int blocked = 0, free = 0, hits = 0;
  for (const double speed : {3.0, 5.0, -3.0, -5.0}) {
    for (double x = -0.8; x < 0.81; x += 0.2) {
      for (const double y : {0.25, 0.35, 0.5}) {
        for (const Eigen::Vector2d& origin :
             {Eigen::Vector2d(0, 0), Eigen::Vector2d(0, -1.5), Eigen::Vector2d(-0.5, 1.9)}) {
          PostScene scene;
          scene.scanners[0].increment = 0.5 * degree;
          scene.scanners[0].yaw = 100 * degree;
          scene.sweep_s = 0.08;
          scene.world.add_box({x, y}, {0.1, 0.1}, 0.8);
          scene.origin = origin;
          scene.look(speed, 0.03);
          // A link of two returns with 1 cm of noise may cut the corner of a post.
          scene.count(11, 0.005);
          blocked += scene.blocked;
          free += scene.free;
          for (const BeamStatus status : scene.strict.statuses) hits += status == BeamStatus::hit ? 1 : 0;
        }
      }
    }
  }
  EXPECT_EQ(free, 0) << "of " << blocked;
  EXPECT_GT(hits, blocked / 3);
}

/// A vehicle of 2 m x 1 m with a scanner on each of two opposite corners.
test::MergedScene pair_of_scanners(double sweep_s) {
  test::MergedScene scene;
  scene.sweep_s = sweep_s;
  scene.outline = {{-1, -0.5}, {1, -0.5}, {1, 0.5}, {-1, 0.5}};
  scene.add_scanner({1, 0.5}, 45);
  scene.add_scanner({-1, -0.5}, -135);
  return scene;
}

TEST(HidingPosts, WhereTheVehicleWasNothingElseWas) {
  for (const double speed : {1.0, 2.0, 5.0, -2.0, -5.0}) {
    for (const double sweep_s : {0.04, 0.1}) {
      test::MergedScene scene = pair_of_scanners(sweep_s);
      scene.look(speed, 0.02);
      scene.count(std::numeric_limits<double>::infinity());
      EXPECT_EQ(scene.free, 2 * scene.blocked) << speed << " m/s, sweep of " << sweep_s << " s";
    }
  }
}

TEST(HidingPosts, SingleBeamsWithoutEvidenceOfAVehicleThatDrivesCostLittle) {
  test::MergedScene scene = pair_of_scanners(0.1);
  scene.invalid = 0.03;
  for (int post = 0; post < 12; ++post) {
    const double azimuth = (30 * post + 15) * degree;
    scene.world.add_box({8 * std::cos(azimuth), 8 * std::sin(azimuth)}, {0.3, 0.5}, azimuth);
  }
  scene.look(5, 0);
  scene.count(11);
  int hits = 0;
  for (std::size_t i = 0; i < scene.strict.beams; ++i)
    hits += scene.strict.statuses[i] == BeamStatus::hit ? 1 : 0;
  EXPECT_GT(scene.blocked, 300);
  EXPECT_GT(hits, scene.blocked * 3 / 4);
  EXPECT_LE(scene.free, 2) << "of " << scene.blocked;
}

}  // namespace
}  // namespace lidard
