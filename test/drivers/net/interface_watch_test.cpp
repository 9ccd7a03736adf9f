// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/net/interface_watch.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "test/support/starved.h"

namespace lidard {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

/// Runs `test` in a network namespace of its own; false: that needs privileges.
template <class Test>
bool in_a_network_of_its_own(Test test) {
  bool permitted = false;
  std::thread([&] {
    permitted = unshare(CLONE_NEWNET) == 0;
    if (permitted) test();
  }).join();
  return permitted;
}

bool run(const char* command) { return std::system(command) == 0; }

TEST(InterfaceWatch, TellsWithinATenthOfASecondWhatComesAndGoes) {
  const bool permitted = in_a_network_of_its_own([] {
    boost::asio::io_context io;
    int told = 0;
    InterfaceWatch watch(io, [&] { ++told; });
    ASSERT_EQ(watch.start(), 0);
    const auto tells = [&](const char* change) {
      io.restart();
      io.run_for(milliseconds(150));  // what is still to come of the last change
      const int before = told;
      ASSERT_TRUE(run(change)) << change;
      const test::Starved starved;
      const auto since = Clock::now();
      while (told == before && Clock::now() - since < std::chrono::seconds(10)) {
        io.restart();
        io.run_for(milliseconds(1));
      }
      EXPECT_GT(told, before) << change;
      EXPECT_LT(Clock::now() - since, milliseconds(100) + starved.time()) << change;
    };
    for (const char* change :
         {"ip link add lidar0 type veth peer name dev0", "ip address add 192.168.1.100/24 dev lidar0",
          "ip link set lidar0 up", "ip route add 224.0.0.0/4 dev lidar0",
          "ip address delete 192.168.1.100/24 dev lidar0", "ip link delete lidar0"})
      tells(change);
    io.restart();
    io.run_for(milliseconds(150));
    const int before = told;
    io.restart();
    io.run_for(milliseconds(300));
    EXPECT_EQ(told, before) << "nothing changed";
    watch.stop();
    ASSERT_TRUE(run("ip link set lo up"));
    io.restart();
    io.run_for(milliseconds(150));
    EXPECT_EQ(told, before) << "it was stopped";
  });
  if (!permitted) GTEST_SKIP() << "needs CAP_SYS_ADMIN for a network namespace";
}

TEST(InterfaceWatch, TellsAFloodOfChangesAFewTimesASecond) {
  const bool permitted = in_a_network_of_its_own([] {
    boost::asio::io_context io;
    int told = 0;
    InterfaceWatch watch(io, [&] { ++told; });
    ASSERT_EQ(watch.start(), 0);
    ASSERT_TRUE(
        run("ip link set lo up; for i in $(seq 1 250); do for j in $(seq 1 8); do echo route add "
            "10.$j.$i.0/24 dev lo; done; done | ip -batch -"));
    io.run_for(milliseconds(500));
    EXPECT_GE(told, 1);
    EXPECT_LE(told, 10);
    const int before = told;
    ASSERT_TRUE(run("ip link set lo down"));
    io.restart();
    io.run_for(milliseconds(500));
    EXPECT_GT(told, before) << "a flood is no end";
  });
  if (!permitted) GTEST_SKIP() << "needs CAP_SYS_ADMIN for a network namespace";
}

}  // namespace
}  // namespace lidard
