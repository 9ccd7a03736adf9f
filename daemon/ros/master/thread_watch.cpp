// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/master/thread_watch.h"

#include <ros/init.h>

#include <utility>

#include "daemon/live/thread_priority.h"

namespace lidard {
namespace {

/// A longer call into roscpp waits for the master.
constexpr auto quick_call = std::chrono::milliseconds(300);

struct Names {
  const char* for_debuggers;
  const char* for_people;
};
constexpr Names names[] = {{"lidard-ros", "the ROS thread"},
                           {"lidard-callback", "the thread for ROS callbacks"},
                           {"lidard-master", "the thread that talks to the ROS master"}};

}  // namespace

void ThreadWatch::tick(Thread thread) {
  thread_local bool named = false;
  if (!std::exchange(named, true)) name_this_thread(names[thread].for_debuggers);
  ++rounds_[thread];
  last_[thread] = Clock::now();
}

std::string ThreadWatch::stalled(bool master_answers) {
  const auto called = called_.load();
  const bool waits = called != Clock::time_point() && Clock::now() - called > quick_call;
  if (waits || ros::isShuttingDown()) return {};
  std::array<std::uint64_t, threads> now{};
  std::string stalled;
  for (std::size_t i = 0; i < threads; ++i) {
    now[i] = rounds_[i];
    const bool counts = (i == callbacks ? runs_.load() : now[i] > 0) && (i != master || master_answers);
    if (counts && now[i] == before_[i])
      stalled += (stalled.empty() ? "" : ", ") + std::string(names[i].for_people);
  }
  if (stalled.empty()) before_ = now;
  return stalled;
}

}  // namespace lidard
