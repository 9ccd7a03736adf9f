// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/frame_tree.h"

#include <gtest/gtest.h>

#include <random>

#include "test/support/pipeline_bench.h"

namespace lidard {
namespace {

/// Any place within 3 m and any direction.
Pose random_pose(std::mt19937& random) {
  std::uniform_real_distribution<double> place(-3, 3), turn(-3, 3);
  return make_pose({place(random), place(random), place(random)}, {turn(random), turn(random), turn(random)});
}

SensorConfig sensor_at(const std::string& frame, const Pose& pose) {
  SensorConfig sensor;
  sensor.name = sensor.frame_id = frame;
  sensor.pose = pose;
  return sensor;
}

VirtualScanConfig group_at(const std::string& base_frame, const std::string& frame, const Pose& pose) {
  VirtualScanConfig group;
  group.base_frame = base_frame;
  group.virtual_laser_scan = {frame};
  group.poses[frame] = pose;
  return group;
}

/// A vehicle with a lidar on its roof, a virtual frame in the lidar's frame, another one in base_link, and a
/// chain of further ones; all poses random.
struct Vehicle {
  explicit Vehicle(unsigned seed) : random(seed) {
    for (auto* pose : {&roof, &under, &bumper, &out}) *pose = random_pose(random);
    config.vehicle.base_frame = "base";
    config.sensors = {sensor_at("roof", roof)};
    config.virtual_scans = {group_at("roof", "under", under), group_at("base", "bumper", bumper)};
    MergedScanConfig merged;
    merged.destination_frame = "out";
    merged.destination_pose = out;
    config.merged_scans = {merged};
  }
  Pose find(const std::string& parent, const std::string& child) {
    const FrameTree tree(config, tf);
    Pose pose = Pose::Identity();
    why.clear();
    found = tree.find(parent, child, test::bench_begin, pose, why);
    return pose;
  }

  std::mt19937 random;
  Config config;
  test::KnownTransforms tf;
  Pose roof, under, bumper, out;
  bool found = false;
  std::string why;
};

void expect_same(const Pose& is, const Pose& should, const char* what) {
  EXPECT_TRUE(is.isApprox(should, 1e-9)) << what << "\n" << is.matrix() << "\n" << should.matrix();
}

TEST(FrameTree, ChainsOfConfiguredPosesAreMultipliedFromTheBaseOutwards) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    Vehicle v(seed);
    const Pose base_under = v.roof * v.under;
    expect_same(v.find("base", "roof"), v.roof, "one link");
    expect_same(v.find("base", "under"), base_under, "two links");
    expect_same(v.find("under", "base"), base_under.inverse(), "backwards");
    expect_same(v.find("bumper", "under"), v.bumper.inverse() * base_under, "from one branch to another");
    expect_same(v.find("under", "roof"), v.under.inverse(), "to its own parent");
    expect_same(v.find("out", "bumper"), v.out.inverse() * v.bumper, "an output's frame");
    expect_same(v.find("roof", "roof"), Pose::Identity(), "itself");
    EXPECT_TRUE(v.found);
    EXPECT_EQ(v.tf.asked, 0) << "nothing of this is of tf";
  }
}

TEST(FrameTree, WhereTheConfigurationEndsTfIsAskedForTheRest) {
  Vehicle v(1);
  v.config.virtual_scans.push_back(group_at("mast", "top", v.bumper));
  v.find("base", "top");
  EXPECT_FALSE(v.found);
  EXPECT_EQ(v.why, "no tf from mast to base");
  const Pose mast = random_pose(v.random);
  v.tf.set("base", "mast", mast);
  expect_same(v.find("base", "top"), mast * v.bumper, "a frame in a frame of tf");
  expect_same(v.find("top", "under"), (mast * v.bumper).inverse() * v.roof * v.under, "both kinds");
  EXPECT_TRUE(v.found);
  v.find("nowhere", "roof");
  EXPECT_FALSE(v.found);
  EXPECT_EQ(v.why, "no tf from nowhere to base");
  v.find("roof", "nowhere");
  EXPECT_FALSE(v.found);
  EXPECT_TRUE((v.find("nowhere", "nowhere"), v.found)) << "a frame is where it is";
}

TEST(FrameTree, PosesThatGoInACircleEndInAQuestionToTf) {
  Vehicle v(2);
  v.config.virtual_scans = {group_at("one", "two", v.roof), group_at("two", "one", v.under)};
  v.find("base", "one");
  EXPECT_FALSE(v.found);
}

TEST(FrameTree, TheFirstEntryThatNamesAFrameCountsAndTfStaticHoldsEachOnce) {
  Vehicle v(3);
  v.config.virtual_scans.push_back(group_at("base", "roof", v.bumper));
  v.config.virtual_scans.push_back(group_at("base", "base", Pose::Identity()));
  expect_same(v.find("base", "roof"), v.roof, "the sensor's own entry");
  const FrameTree tree(v.config, v.tf);
  std::vector<std::string> links;
  for (const StaticTransform& one : tree.transforms()) links.push_back(one.parent + " -> " + one.child);
  EXPECT_EQ(links,
            (std::vector<std::string>{"base -> roof", "base -> out", "roof -> under", "base -> bumper"}));
  expect_same(tree.transforms()[2].pose, v.under, "in its own parent, not in base");
}

}  // namespace
}  // namespace lidard
