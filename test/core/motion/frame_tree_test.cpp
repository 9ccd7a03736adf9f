// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/frame_tree.h"

#include <gtest/gtest.h>

#include <random>

namespace lidard {
namespace {

/// Any place within 3 m and any direction.
Pose random_pose(std::mt19937& random) {
  std::uniform_real_distribution<double> place(-3, 3), turn(-3, 3);
  return make_pose({place(random), place(random), place(random)}, {turn(random), turn(random), turn(random)});
}

/// Knows the poses of frames in "base" that it is given, and how often it was asked.
struct Tf final : TransformSource {
  bool lookup(const std::string& parent, const std::string& child, Stamp, Pose& pose,
              std::string& why_not) override {
    ++asked;
    const auto found = in_base.find(child);
    const bool is_known = parent == "base" && found != in_base.end();
    if (is_known) pose = found->second;
    why_not = is_known ? "" : "no tf from " + child + " to " + parent;
    return is_known;
  }
  std::map<std::string, Pose> in_base;
  int asked = 0;
};

/// A vehicle with a lidar on its roof, a virtual frame in the lidar's frame, another one in base, and the
/// frame of an output; all poses random.
struct Vehicle {
  explicit Vehicle(unsigned seed) : random(seed) {
    for (auto* pose : {&roof, &under, &bumper, &out}) *pose = random_pose(random);
    fixed = {
        {"base", "roof", roof}, {"base", "out", out}, {"roof", "under", under}, {"base", "bumper", bumper}};
  }
  Pose find(const std::string& parent, const std::string& child) {
    const FrameTree tree("base", fixed, tf);
    Pose pose = Pose::Identity();
    why.clear();
    found = tree.find(parent, child, Stamp{}, pose, why);
    return pose;
  }

  std::mt19937 random;
  std::vector<StaticTransform> fixed;
  Tf tf;
  Pose roof, under, bumper, out;
  bool found = false;
  std::string why;
};

void expect_same(const Pose& is, const Pose& should, const char* what) {
  EXPECT_TRUE(is.isApprox(should, 1e-9)) << what << "\n" << is.matrix() << "\n" << should.matrix();
}

TEST(FrameTree, ChainsOfFixedPosesAreMultipliedFromTheBaseOutwards) {
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

TEST(FrameTree, WhereFixedPosesEndTfIsAskedForTheRest) {
  Vehicle v(1);
  v.fixed.push_back({"mast", "top", v.bumper});
  v.find("base", "top");
  EXPECT_FALSE(v.found);
  EXPECT_EQ(v.why, "no tf from mast to base");
  const Pose mast = random_pose(v.random);
  v.tf.in_base["mast"] = mast;
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
  v.fixed = {{"one", "two", v.roof}, {"two", "one", v.under}};
  v.find("base", "one");
  EXPECT_FALSE(v.found);
}

TEST(FrameTree, TheFirstPoseOfAFrameCountsAndOthersReplaceThem) {
  Vehicle v(3);
  v.fixed.push_back({"base", "roof", v.bumper});
  expect_same(v.find("base", "roof"), v.roof, "the first one");
  FrameTree tree("base", v.fixed, v.tf);
  tree.configure("under", {{"under", "roof", v.out}});
  EXPECT_EQ(tree.fixed().size(), 1U);
  Pose pose;
  ASSERT_TRUE(tree.find("under", "roof", Stamp{}, pose, v.why));
  expect_same(pose, v.out, "another base");
  EXPECT_FALSE(tree.find("under", "bumper", Stamp{}, pose, v.why)) << "its pose is gone";
}

}  // namespace
}  // namespace lidard
