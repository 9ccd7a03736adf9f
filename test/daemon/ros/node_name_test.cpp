// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/master/node_name.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <optional>
#include <thread>

namespace lidard {
namespace {

using namespace std::chrono_literals;

TEST(NodeName, IsOfOneDaemonOfAComputerAndFreeAtOnceWhenThatEnds) {
  const std::string node = "/name_test_" + std::to_string(getpid());
  const std::string master = "http://localhost:11311";
  std::optional<NodeName> first(std::in_place, node, master);
  NodeName second(node, master);
  EXPECT_TRUE(first->lock());
  EXPECT_TRUE(first->lock());
  EXPECT_FALSE(second.lock());
  EXPECT_EQ(second.conflict(), "") << "the first may just be ending";
  EXPECT_TRUE(NodeName(node + "_2", master).lock());
  EXPECT_TRUE(NodeName(node, "http://localhost:11312").lock()) << "they do not meet";
  first.reset();
  EXPECT_TRUE(second.lock());
  EXPECT_EQ(second.conflict(), "");
}

TEST(NodeName, ThatIsTakenForThreeSecondsIsAConflictThatNamesTheRemedy) {
  const std::string node = "/space/conflict_test_" + std::to_string(getpid());
  NodeName first(node, "http://localhost:11311");
  NodeName second(node, "http://localhost:11311");
  EXPECT_TRUE(first.lock());
  EXPECT_FALSE(second.lock());
  std::this_thread::sleep_for(3100ms);
  EXPECT_FALSE(second.lock());
  EXPECT_THAT(second.conflict(), testing::HasSubstr("another daemon on this computer has the node name " + node));
  EXPECT_THAT(second.conflict(), testing::HasSubstr("__name:=conflict_test_" + std::to_string(getpid()) + "_2"));
}

}  // namespace
}  // namespace lidard
