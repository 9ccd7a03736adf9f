// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/ros/in/inputs.h"

namespace lidard::test {

/// Tasks posted to the "sensor thread", which here is the test.
class Posted {
 public:
  RosPost post() {
    return [this](const std::string&, RosTask task) {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(task));
    };
  }
  /// Runs what comes, at the time `now`, until `done` or the time is up.
  bool run_until(MessageReceiver& receiver, Stamp now, const std::function<bool()>& done,
                 std::chrono::milliseconds limit = std::chrono::seconds(120)) {
    const auto end = std::chrono::steady_clock::now() + limit;
    while (!done() && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      std::vector<RosTask> tasks;
      {
        const std::lock_guard lock(mutex_);
        tasks.swap(waiting_);
      }
      for (const auto& task : tasks) task(receiver, now);
    }
    return done();
  }

 private:
  std::mutex mutex_;
  std::vector<RosTask> waiting_;
};

}  // namespace lidard::test
