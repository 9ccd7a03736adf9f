// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_master.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>

#include "daemon/ros/ros_environment.h"
#include "test/support/ros_listener.h"
#include "test/support/starved.h"

namespace lidard {
namespace {

using namespace std::chrono_literals;
using test::in_own_process;
using test::RosMaster;
using SteadyClock = std::chrono::steady_clock;

/// Far above what a call takes on a crowded machine, far below what roscpp takes when the master hangs (15 s
/// and more).
constexpr auto surely_not_hanging = 3s;

TEST(RosLogFolder, IsChosenWhereTheHomeCannotBeWritten) {
  in_own_process([] {
    unsetenv("ROS_LOG_DIR");
    unsetenv("ROS_HOME");
    setenv("HOME", "/nonexistent", 1);
    setenv("RUNTIME_DIRECTORY", "/run/lidard", 1);
    choose_ros_log_folder();
    ASSERT_NE(std::getenv("ROS_LOG_DIR"), nullptr);
    EXPECT_STREQ(std::getenv("ROS_LOG_DIR"), "/run/lidard");
    unsetenv("ROS_LOG_DIR");
    setenv("HOME", "/tmp", 1);
    choose_ros_log_folder();
    EXPECT_EQ(std::getenv("ROS_LOG_DIR"), nullptr);
  });
}

TEST(MasterClient, GivesUpAfterItsLimit) {
  in_own_process([] {
    RosMaster master;
    MasterClient client({"127.0.0.1", master.port()}, "/test");
    const test::Starved starved;
    auto begin = SteadyClock::now();
    EXPECT_FALSE(client.pid());
    EXPECT_LT(SteadyClock::now() - begin, surely_not_hanging + starved.time()) << "nobody listens";
    master.start();
    EXPECT_TRUE(client.pid());
    master.pause();
    begin = SteadyClock::now();
    EXPECT_FALSE(client.pid());
    EXPECT_EQ(client.error(), "no answer in time");
    EXPECT_LT(SteadyClock::now() - begin, surely_not_hanging + starved.time());
  });
}

TEST(MasterUri, IsTakenApart) {
  const auto uri = parse_server_uri("http://robot.local:11311/");
  ASSERT_TRUE(uri);
  EXPECT_EQ(uri->host, "robot.local");
  EXPECT_EQ(uri->port, 11311);
  for (const char* wrong : {"", "robot:11311", "http://robot", "http://:11311", "http://robot:0",
                            "http://robot:99999", "http://robot:11311x"})
    EXPECT_FALSE(parse_server_uri(wrong)) << wrong;
}

}  // namespace
}  // namespace lidard
