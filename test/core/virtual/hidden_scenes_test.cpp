// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Scenes made to hide a thing that reaches through a virtual scan's plane: no beam onto it is free, and none
// sees what is behind it.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/motion/pose_track.h"
#include "test/core/virtual/cut_bench.h"

namespace lidard {
namespace {

using test::cut::wall;

sim::Object box(const Eigen::Vector3d& center, const Eigen::Vector3d& size, double yaw = 0) {
  sim::Object one = test::cut::box(center, size);
  one.pose = make_pose(center, {0, 0, yaw});
  return one;
}

/// A lidar of 16 rings and a virtual scan of it.
struct HidingScene {
  explicit HidingScene(double lidar_height, GroundModel ground = GroundModel::slope) {
    lidar.pose = make_pose({0, 0, lidar_height}, {0, 0, 0});
    settings.how.noise = 0.02;
    settings.ground.model = ground;
  }
  ScanGrid grid() const { return test::full_circle(720, range_max); }
  void look(const Cloud& cloud, const CloudMotion* motion = nullptr) {
    Virtualizer virtualizer(grid(), band, 1, settings);
    virtualizer.set_cloud(cloud, lidar.pose, motion);
    virtualizer.project(0, frame.inverse() * lidar.pose,
                        {{Profile::strict, &strict}, {Profile::safety, &safety}});
  }
  void look() {
    sim::Rng rng(1);
    look(sim::measure(yard, lidar, rng));
  }
  /// m to what reaches through the plane by 0.2 m; infinite: nothing.
  double solid(double angle) const {
    double nearest = 1e9, farthest = 0;
    for (const double higher : {-0.2, 0.0, 0.2}) {
      const Eigen::Vector3d from = frame.translation() + Eigen::Vector3d(0, 0, higher);
      const double range =
          yard.cast({from, frame.linear() * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0)}, false);
      nearest = std::min(nearest, range);
      farthest = std::max(farthest, range);
    }
    return farthest - nearest < 0.3 ? farthest : 1e9;
  }
  struct Seen {
    int solid = 0, overlooked = 0;
  };
  /// Counts the beams onto solid things within `half` rad of ahead, and in both profiles those that are free
  /// or see farther by `depth` m.
  Seen seen(double half, double depth = 0.3) const {
    Seen count;
    for (std::size_t beam = 0; beam < strict.beams; ++beam) {
      const double angle = std::remainder(grid().angle(beam), 2 * pi_d), step = grid().increment / 2;
      const double truth = solid(angle);
      if (std::abs(angle) > half || !(truth < range_max - 0.3)) continue;
      if (!(solid(angle - step) < truth + 1 && solid(angle + step) < truth + 1)) continue;
      ++count.solid;
      for (const PlanarScan* scan : {&strict, &safety}) {
        const bool farther = scan->statuses[beam] == BeamStatus::hit &&
                             static_cast<double>(scan->ranges[beam]) > truth + depth + 0.02 * truth;
        if (scan->statuses[beam] == BeamStatus::none || farther) ++count.overlooked;
      }
    }
    return count;
  }

  sim::Yard yard;
  sim::YardLidar lidar = test::cut::lidar16();
  Pose frame = Pose::Identity();
  VirtualSettings settings = test::cut::settings_with_ground();
  HeightBand band;
  double range_max = 10;
  PlanarScan strict, safety;
};

void expect_none_overlooked(const HidingScene& scene, const std::string& what, double half = 4) {
  const HidingScene::Seen seen = scene.seen(half);
  EXPECT_GT(seen.solid, 3) << what;
  EXPECT_EQ(seen.overlooked, 0) << what << ": of " << seen.solid;
}

TEST(HiddenScenes, ABoxThatOneRingAloneMeetsIsNoRiseOfTheGround) {
  for (const double height : {1.0, 2.0}) {
    for (const double plane : {0.3, 0.4, 0.5}) {
      for (const double over : {0.25, 0.3, 0.5}) {
        for (double at = 8; at <= 20; at += 1) {
          HidingScene scene(height);
          scene.range_max = 3;
          scene.frame = make_pose({at - 1.2, 0, plane}, {0, 0, 0});
          const double top = plane + over;
          scene.yard.objects = {box({at + 0.5, 0, top / 2}, {1, 1, top}), wall(60, -40, 60, 40, 4)};
          scene.look();
          // Where no ring meets the box, or all at heights that count as ground, nothing can be known of it.
          bool is_met = false;
          for (const double elevation : scene.lidar.elevations) {
            const double meets = height + at * std::tan(elevation);
            is_met = is_met || (meets > scene.settings.ground.tolerance + 0.02 && meets < top - 0.02);
          }
          if (!is_met) continue;
          // The box is 1 m deep, and its top is seen, too.
          const HidingScene::Seen seen = scene.seen(0.25, 1);
          EXPECT_EQ(seen.overlooked, 0) << "lidar at " << height << ", plane " << plane << ", top " << top
                                        << " at " << at << ": of " << seen.solid;
        }
      }
    }
  }
}

TEST(HiddenScenes, WallsThatMeetAreNoLevelTop) {
  for (const GroundModel ground : {GroundModel::plane, GroundModel::slope}) {
    for (const double noise : {0.0, 0.02}) {
      for (const std::size_t walls : {1U, 2U, 4U}) {
        HidingScene scene(2, ground);
        scene.lidar.noise = noise;
        scene.frame = make_pose({20, 0, 1}, {0, 0, 0});
        scene.range_max = 8;
        constexpr double w = 24, top = 1.4;
        scene.yard.objects = {wall(w, -w, w, w, top), wall(w, w, -w, w, top), wall(-w, w, -w, -w, top),
                              wall(-w, -w, w, -w, top)};
        scene.yard.objects.resize(walls);
        scene.yard.objects.push_back(wall(-70, 30, -70, 34, 9));
        scene.look();
        expect_none_overlooked(scene, std::to_string(walls) + " walls, noise " + std::to_string(noise));
      }
    }
  }
}

TEST(HiddenScenes, AHigherThingBehindAWallIsNotItsTop) {
  for (const double noise : {0.0, 0.02}) {
    for (const double yaw_deg : {0.0, 10.0, 20.0, 25.0, 30.0}) {
      HidingScene scene(2, GroundModel::plane);
      scene.lidar.noise = noise;
      scene.frame = make_pose({8.5, 0, 0.5}, {0, 0, 0});
      scene.range_max = 3.2;
      scene.yard.objects = {box({10.1, 0, 0.36}, {0.2, 3, 0.72}),
                            box({12.6, 0, 0.4}, {0.2, 2.6, 0.8}, yaw_deg * degree)};
      scene.look();
      // At the very corner of the second thing, and where noise hides the bend.
      const HidingScene::Seen seen = scene.seen(1.2);
      EXPECT_GT(seen.solid, 150);
      EXPECT_LE(seen.overlooked, noise > 0 ? 12 : 2) << yaw_deg << " deg, noise " << noise;
    }
  }
}

TEST(HiddenScenes, ALowWallBesideAHighOneDoesNotLowerIt) {
  for (const GroundModel ground : {GroundModel::plane, GroundModel::slope}) {
    for (const double noise : {0.0, 0.02}) {
      HidingScene scene(2, ground);
      scene.lidar.noise = noise;
      scene.frame = make_pose({6.5, 0, 0.5}, {0, 0, 0});
      scene.range_max = 6;
      scene.yard.objects = {wall(8, -0.5, 8, 0.5, 0.72), wall(8, 0.5, 9.65, 1.2, 0.45),
                            wall(25, -40, 25, 40, 4)};
      scene.look();
      expect_none_overlooked(scene, "noise " + std::to_string(noise), 1.5);
    }
  }
}

TEST(HiddenScenes, ABandIsNotFreeWhereItsUpperPartIsAboveAllBeams) {
  HidingScene scene(2);
  scene.lidar.elevations = sim::even_rings(64, -24.8, 2);
  scene.lidar.noise = 0.01;
  scene.settings.mode = CutMode::band;
  scene.band = {0.1, 2.5};
  scene.frame = make_pose({4.5, 0, 0}, {0, 0, 0});
  scene.range_max = 5;
  scene.yard.objects = {box({7, 0, 2.4}, {0.2, 3, 0.2}), wall(30, -40, 30, 40, 4)};
  scene.look();
  int free = 0;
  for (std::size_t beam = 0; beam < scene.strict.beams; ++beam) {
    if (std::abs(std::remainder(scene.grid().angle(beam), 2 * pi_d)) < 0.5)
      free += scene.strict.statuses[beam] == BeamStatus::none ? 1 : 0;
  }
  EXPECT_EQ(free, 0) << "of a bar 2.3 m above the ground, 7 m ahead";
  // Farther away the topmost ring has looked over all of the band.
  scene.frame = make_pose({20, 0, 0}, {0, 0, 0});
  scene.look();
  free = 0;
  for (std::size_t beam = 0; beam < scene.strict.beams; ++beam)
    free += scene.strict.statuses[beam] == BeamStatus::none ? 1 : 0;
  EXPECT_GT(free, 300);
}

TEST(HiddenScenes, ASecondLidarWithoutACloudOpensNoShadow) {
  HidingScene scene(2);
  scene.frame = make_pose({8, -14, 0.5}, {0, 0, pi_d / 2});
  scene.range_max = 40;
  scene.yard.objects = {box({5, 0, 1.5}, {0.2, 0.2, 3}), box({8, 0, 0.6}, {0.2, 0.2, 1.2}),
                        wall(-30, 8, 30, 8, 4), wall(25, -40, 25, 40, 4)};
  sim::YardLidar other = scene.lidar;
  other.pose = make_pose({0, 1, 2}, {0, 0, 0});
  sim::Rng rng(1);
  const Cloud first = sim::measure(scene.yard, scene.lidar, rng);
  const Cloud second = sim::measure(scene.yard, other, rng);
  Virtualizer virtualizer(scene.grid(), scene.band, 1, scene.settings, 2);
  const std::vector<Pose> poses = {scene.frame.inverse() * scene.lidar.pose,
                                   scene.frame.inverse() * other.pose};
  for (const Cloud* seen : {&second, static_cast<const Cloud*>(nullptr)}) {
    virtualizer.set_clouds({{&first, scene.lidar.pose}, {seen, other.pose}});
    virtualizer.project(0, poses.data(),
                        {{Profile::strict, &scene.strict}, {Profile::safety, &scene.safety}});
  }
  const std::size_t onto_thing = scene.strict.beams / 2;
  EXPECT_NEAR(scene.solid(scene.grid().angle(onto_thing)), 13.9, 0.01) << "in the shadow of a post";
  EXPECT_EQ(scene.strict.statuses[onto_thing], BeamStatus::invalid);
  EXPECT_NE(scene.safety.statuses[onto_thing], BeamStatus::none);
}

TEST(HiddenScenes, WhileTheVehicleDrivesPostsHideWhatIsBehindThem) {
  for (const double speed : {2.0, 5.0, 10.0}) {
    int solid = 0, overlooked = 0;
    for (int azimuth = 3; azimuth < 360; azimuth += 14) {
      for (const double away : {9.5, 14.2}) {
        HidingScene scene(2, GroundModel::plane);
        scene.lidar.noise = 0.01;
        constexpr double turn_s = 0.1;
        scene.lidar.path = [&](Span t) {
          return make_pose({speed * (seconds(t) - turn_s), 0, 2}, {0, 0, 0});
        };
        const double a = azimuth * degree, x = std::cos(a), y = std::sin(a);
        scene.yard.objects = {box({away * x, away * y, 0.36}, {0.3, 0.3, 0.72}, a), wall(22, -22, 22, 22, 4),
                              wall(22, 22, -22, 22, 4), wall(-22, 22, -22, -22, 4),
                              wall(-22, -22, 22, -22, 4)};
        sim::Rng rng(1);
        const Cloud cloud = sim::measure(scene.yard, scene.lidar, rng);
        PoseTrack track;
        for (int i = -2; i <= 12; ++i) {
          const double t = 0.01 * i;
          track.add(cloud.stamp + span_from_seconds(t), make_pose({speed * (t - turn_s), 0, 0}, {0, 0, 0}));
        }
        CloudMotion motion;
        ASSERT_TRUE(motion.find(cloud, scene.lidar.pose, track));
        scene.frame = make_pose({(away - 2) * x, (away - 2) * y, 0.5}, {0, 0, a});
        scene.range_max = 5;
        scene.look(cloud, &motion);
        const HidingScene::Seen seen = scene.seen(0.06);
        solid += seen.solid;
        overlooked += seen.overlooked;
      }
    }
    EXPECT_GT(solid, 300);
    EXPECT_LE(overlooked, solid / 100) << speed << " m/s, of " << solid;
  }
}

}  // namespace
}  // namespace lidard
