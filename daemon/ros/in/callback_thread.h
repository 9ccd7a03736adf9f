// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>

#include <atomic>
#include <string>
#include <thread>

#include "daemon/ros/master/thread_watch.h"

namespace lidard {

/// The only thread of roscpp's callbacks: messages, requests and tf. Lives while ROS runs. To be called by
/// the master thread.
class RosCallbackThread {
 public:
  explicit RosCallbackThread(ThreadWatch& watch) : thread_([this, &watch] { run(watch); }) {}
  ~RosCallbackThread() { stop(); }
  RosCallbackThread(const RosCallbackThread&) = delete;
  RosCallbackThread& operator=(const RosCallbackThread&) = delete;

  /// A handle whose callbacks come in this thread.
  ros::NodeHandle node(const std::string& name_space = "") {
    ros::NodeHandle node(name_space);
    node.setCallbackQueue(&queue_);
    return node;
  }
  /// Ends the callbacks.
  void stop() {
    queue_.disable();
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run(ThreadWatch& watch) {
    while (!stopping_) {
      watch.tick(ThreadWatch::callbacks);
      queue_.callAvailable(ros::WallDuration(0.1));
    }
  }

  ros::CallbackQueue queue_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace lidard
