// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/pose_edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "core/base/angle.h"

namespace lidard {
namespace {

const Pose wanted = make_pose({1.25, -0.5, 0.3}, {0, 0, 90 * rad_per_deg});

TEST(PoseEdit, ReplacesNumbersAndLeavesAllElseAsItIs) {
  const char* const text =
      "# yard truck\nsensors:\n  left:   # front\n    model: sick_microscan3\n"
      "    pose: {xyz: [0, 1, 0.35], rpy_deg: [0, 0, 45]}   # by tape\n  right: {pose: {xyz: [0, 0, 0]}}\n";
  EXPECT_EQ(with_mounts(text, {{"left", {wanted, {}}}}),
            "# yard truck\nsensors:\n  left:   # front\n    model: sick_microscan3\n"
            "    pose: {xyz: [1.25, -0.5, 0.3], rpy_deg: [0, 0, 90]}   # by tape\n  right: {pose: {xyz: [0, "
            "0, 0]}}\n");
}

TEST(PoseEdit, KeepsTheUnitOfAnglesAndAddsThoseThatAreMissing) {
  EXPECT_EQ(with_mounts("sensors: {a: {pose: {rpy: [0, 0, 0], xyz: [0, 0, 0]}}}", {{"a", {wanted, {}}}}),
            "sensors: {a: {pose: {rpy: [0, 0, 1.570796], xyz: [1.25, -0.5, 0.3]}}}");
  EXPECT_EQ(with_mounts("sensors: {a: {pose: {xyz: [0, 0, 0]}}}", {{"a", {wanted, {}}}}),
            "sensors: {a: {pose: {xyz: [1.25, -0.5, 0.3], rpy_deg: [0, 0, 90]}}}");
  EXPECT_EQ(
      with_mounts("sensors:\n  a:\n    pose:\n      xyz: [0, 0, 0]\n    model: b\n", {{"a", {wanted, {}}}}),
      "sensors:\n  a:\n    pose:\n      xyz: [1.25, -0.5, 0.3]\n      rpy_deg: [0, 0, 90]\n    model: b\n");
}

TEST(PoseEdit, WritesATimeOffsetInPlaceOfTheOldOneOrBesideThePose) {
  const MountEdit edit{wanted, -0.0123};
  EXPECT_EQ(
      with_mounts("sensors: {a: {time_offset: 0.5, pose: {xyz: [0, 0, 0], rpy: [0, 0, 0]}}}", {{"a", edit}}),
      "sensors: {a: {time_offset: -0.0123, pose: {xyz: [1.25, -0.5, 0.3], rpy: [0, 0, 1.570796]}}}");
  EXPECT_EQ(with_mounts("sensors: {a: {model: b, pose: {xyz: [0, 0, 0], rpy: [0, 0, 0]}}}", {{"a", edit}}),
            "sensors: {a: {model: b, time_offset: -0.0123, pose: {xyz: [1.25, -0.5, 0.3], rpy: [0, 0, "
            "1.570796]}}}");
  EXPECT_EQ(
      with_mounts("sensors:\n  a:   # left\n    pose: {xyz: [0, 0, 0], rpy: [0, 0, 0]}  # tape\n",
                  {{"a", edit}}),
      "sensors:\n  a:   # left\n    time_offset: -0.0123\n    pose: {xyz: [1.25, -0.5, 0.3], rpy: [0, 0, "
      "1.570796]}  # tape\n");
}

TEST(PoseEdit, WritesSmallNumbersWithoutAnExponent) {
  EXPECT_EQ(with_mounts("sensors: {a: {pose: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}}}",
                        {{"a", {make_pose({-0.0001, 0, 0.00001}, {0, 0, 0}), 0.00002}}}),
            "sensors: {a: {time_offset: 0.00002, pose: {xyz: [-0.0001, 0, 0], rpy_deg: [0, 0, 0]}}}");
}

TEST(PoseEdit, KeepsAByteOrderMarkFollowsAnAliasAndRefusesAPoseThatIsMergedIn) {
  const std::string mark = "\xEF\xBB\xBF", begin = "sensors: {a: {pose: {xyz: [";
  EXPECT_EQ(with_mounts(mark + begin + "0, 0, 0], rpy_deg: [0, 0, 0]}}}",
                        {{"a", {make_pose({1, 2, 3}, {0, 0, 0}), {}}}}),
            mark + begin + "1, 2, 3], rpy_deg: [0, 0, 0]}}}");
  EXPECT_EQ(with_mounts("p: &p {xyz: [0, 0, 0], rpy: [0, 0, 0]}\nsensors: {a: {pose: *p}}",
                        {{"a", {make_pose({1, 2, 3}, {0, 0, 0}), {}}}}),
            "p: &p {xyz: [1, 2, 3], rpy: [0, 0, 0]}\nsensors: {a: {pose: *p}}");
  EXPECT_THROW(with_mounts("v: &v {pose: {xyz: [0, 0, 0]}}\nsensors: {a: {<<: *v}}", {{"a", {wanted, {}}}}),
               std::runtime_error);
}

TEST(PoseEdit, NamesTheLineOfAPoseThatItCannotReplace) {
  try {
    with_mounts("sensors:\n  a:\n    pose:\n      xyz:\n        - 0\n        - 0\n        - 0\n",
                {{"a", {wanted, {}}}});
    FAIL() << "was replaced";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("line 5: write the pose of a as {xyz: [x, y, z], rpy_deg"));
  }
}

}  // namespace
}  // namespace lidard
