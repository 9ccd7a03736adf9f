// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/mount_edit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/angle.h"
#include "drivers/config_error.h"

namespace lidard {
namespace {

std::string edited(const std::string& text, const std::map<std::string, MountEdit>& mounts) {
  return with_mounts(text, "a.yaml", mounts);
}

const Pose wanted = make_pose({1.25, -0.5, 0.3}, {0, 0, 90 * rad_per_deg});

TEST(MountEdit, ReplacesNumbersAndLeavesAllElseAsItIs) {
  const char* const text =
      "# yard truck\nsensors:\n  left:   # front\n    model: sick_microscan3\n"
      "    pose: {xyz: [0, 1, 0.35], rpy_deg: [0, 0, 45]}   # by tape\n  right: {pose: {xyz: [0, 0, 0]}}\n";
  EXPECT_EQ(edited(text, {{"left", {wanted, {}}}}),
            "# yard truck\nsensors:\n  left:   # front\n    model: sick_microscan3\n"
            "    pose: {xyz: [1.25, -0.5, 0.3], rpy_deg: [0, 0, 90]}   # by tape\n  right: {pose: {xyz: [0, "
            "0, 0]}}\n");
}

TEST(MountEdit, KeepsTheUnitOfAnglesAndAddsThoseThatAreMissing) {
  EXPECT_EQ(edited("sensors: {a: {pose: {rpy: [0, 0, 0], xyz: [0, 0, 0]}}}", {{"a", {wanted, {}}}}),
            "sensors: {a: {pose: {rpy: [0, 0, 1.570796], xyz: [1.25, -0.5, 0.3]}}}");
  EXPECT_EQ(edited("sensors: {a: {pose: {xyz: [0, 0, 0]}}}", {{"a", {wanted, {}}}}),
            "sensors: {a: {pose: {xyz: [1.25, -0.5, 0.3], rpy_deg: [0, 0, 90]}}}");
  EXPECT_EQ(
      edited("sensors:\n  a:\n    pose:\n      xyz: [0, 0, 0]\n    model: b\n", {{"a", {wanted, {}}}}),
      "sensors:\n  a:\n    pose:\n      xyz: [1.25, -0.5, 0.3]\n      rpy_deg: [0, 0, 90]\n    model: b\n");
}

TEST(MountEdit, WritesATimeOffsetInPlaceOfTheOldOneOrBesideThePose) {
  const MountEdit edit{wanted, -0.0123};
  EXPECT_EQ(edited("sensors: {a: {time_offset: 0.5, pose: {xyz: [0, 0, 0], rpy: [0, 0, 0]}}}", {{"a", edit}}),
            "sensors: {a: {time_offset: -0.0123, pose: {xyz: [1.25, -0.5, 0.3], rpy: [0, 0, 1.570796]}}}");
  EXPECT_EQ(edited("sensors: {a: {model: b, pose: {xyz: [0, 0, 0], rpy: [0, 0, 0]}}}", {{"a", edit}}),
            "sensors: {a: {model: b, time_offset: -0.0123, pose: {xyz: [1.25, -0.5, 0.3], rpy: [0, 0, "
            "1.570796]}}}");
  EXPECT_EQ(
      edited("sensors:\n  a:   # left\n    pose: {xyz: [0, 0, 0], rpy: [0, 0, 0]}  # tape\n", {{"a", edit}}),
      "sensors:\n  a:   # left\n    time_offset: -0.0123\n    pose: {xyz: [1.25, -0.5, 0.3], rpy: [0, 0, "
      "1.570796]}  # tape\n");
}

TEST(MountEdit, WritesSmallNumbersWithoutAnExponent) {
  EXPECT_EQ(edited("sensors: {a: {pose: {xyz: [0, 0, 0], rpy_deg: [0, 0, 0]}}}",
                   {{"a", {make_pose({-0.0001, 0, 0.00001}, {0, 0, 0}), 0.00002}}}),
            "sensors: {a: {time_offset: 0.00002, pose: {xyz: [-0.0001, 0, 0], rpy_deg: [0, 0, 0]}}}");
}

TEST(MountEdit, ReplacesNumbersOfBlockStyleWithAllThatStandsBetweenThem) {
  const char* const text =
      "sensors:\n"
      "    left:\n"
      "        pose:   # by tape\n"
      "            rpy_deg:\n"
      "            - 0     # roll\n"
      "            # a comment: [with, brackets]\n"
      "            -    1.5e-1\n"
      "            - 45.0\n"
      "\n"
      "            xyz: [ 0,   # ahead ]\n"
      "                   1, 0.35 ]  # height\n"
      "        model: sick_microscan3\n";
  EXPECT_EQ(edited(text, {{"left", {wanted, 0.01}}}),
            "sensors:\n"
            "    left:\n"
            "        time_offset: 0.01\n"
            "        pose:   # by tape\n"
            "            rpy_deg:\n"
            "            - 0     # roll\n"
            "            # a comment: [with, brackets]\n"
            "            -    0\n"
            "            - 90\n"
            "\n"
            "            xyz: [ 1.25,   # ahead ]\n"
            "                   -0.5, 0.3 ]  # height\n"
            "        model: sick_microscan3\n");
}

TEST(MountEdit, AddsAnglesBelowTheLineOfTheListAndKeepsItsComment) {
  EXPECT_EQ(edited("sensors:\n  a:\n    pose:\n      xyz: [0, 0, 0]   # tape\n    model: b\n",
                   {{"a", {wanted, {}}}}),
            "sensors:\n  a:\n    pose:\n      xyz: [1.25, -0.5, 0.3]   # tape\n"
            "      rpy_deg: [0, 0, 90]\n    model: b\n");
  EXPECT_EQ(
      edited("sensors:\r\n  a:\r\n    pose:\r\n      xyz:\r\n      - 0\r\n      - 0\r\n      - 0 # z\r\n",
             {{"a", {wanted, 0.5}}}),
      "sensors:\r\n  a:\r\n    time_offset: 0.5\r\n    pose:\r\n      xyz:\r\n      - 1.25\r\n      - "
      "-0.5\r\n"
      "      - 0.3 # z\r\n      rpy_deg: [0, 0, 90]\r\n");
  EXPECT_EQ(edited("sensors:\n  a:\n    pose:\n      xyz:\n        - 0\n        - 0\n        - 0",
                   {{"a", {wanted, {}}}}),
            "sensors:\n  a:\n    pose:\n      xyz:\n        - 1.25\n        - -0.5\n        - 0.3\n"
            "      rpy_deg: [0, 0, 90]");
  EXPECT_EQ(edited("sensors: {a: {pose: {xyz: [0, 0, 0 # ]\n  ]}}}", {{"a", {wanted, {}}}}),
            "sensors: {a: {pose: {xyz: [1.25, -0.5, 0.3 # ]\n  ], rpy_deg: [0, 0, 90]}}}");
}

TEST(MountEdit, KeepsAByteOrderMark) {
  const std::string mark = "\xEF\xBB\xBF", begin = "sensors: {a: {pose: {xyz: [";
  EXPECT_EQ(edited(mark + begin + "0, 0, 0], rpy_deg: [0, 0, 0]}}}",
                   {{"a", {make_pose({1, 2, 3}, {0, 0, 0}), {}}}}),
            mark + begin + "1, 2, 3], rpy_deg: [0, 0, 0]}}}");
}

TEST(MountEdit, NamesThePlaceOfAMountThatItCannotReplaceAndWhatToWriteThere) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      edited(text, {{"a", {wanted, -0.25}}});
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "was replaced";
  };
  const std::string left =
      "sensors:\n  b: &b {time_offset: &t 0, pose: &p {xyz: &x [0, 0, &z 0], rpy: [0, 0, 0]}}\n";
  const char* const wants =
      "the mount of a is merged in, has an anchor or is an alias, so that it cannot be replaced; expected "
      "time_offset: -0.25, pose: {xyz: [1.25, -0.5, 0.3], rpy_deg: [0, 0, 90]} in the entry of a";
  for (const auto& [entry, place] : std::vector<std::pair<std::string, std::string>>{
           {"  a: *b\n", "3:3"},
           {"  a: {<<: *b, model: c}\n", "3:6"},
           {"  a:\n    pose: *p\n", "4:5"},
           {"  a:\n    pose:\n      xyz: *x\n", "5:7"},
           {"  a:\n    pose:\n      xyz: [0, 0, *z]\n", "5:12"},
           {"  a: {pose: {xyz: [&one 0, 0, 0]}}\n", "3:20"},
           {"  a: {time_offset: *t, pose: {xyz: [0, 0, 0]}}\n", "3:7"},
           {"  a: {pose: {xyz: ['0', 0, 0]}}\n", "3:20"}})
    EXPECT_EQ(message(left + entry), "a.yaml:" + place + ": " + wants) << entry;
}

}  // namespace
}  // namespace lidard
