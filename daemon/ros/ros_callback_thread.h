// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>

#include <algorithm>
#include <any>
#include <atomic>
#include <deque>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/ros/ros_pulse.h"

namespace lidard {

/// Keeps a part of roscpp for ever, so that its destructor does not run: it would wait for the master.
template <class Part>
void leave_behind(Part part) {
  static auto* const left = new std::deque<Part>;
  left->push_back(std::move(part));
}

/// The one thread in which roscpp calls us, for messages, requests and tf alike. Created when ROS runs, gone
/// before ROS ends. Calls belong to the master thread.
class RosCallbackThread {
 public:
  explicit RosCallbackThread(RosPulse& pulse) : thread_([this, &pulse] { run(pulse); }) {}
  ~RosCallbackThread() { stop(); }
  RosCallbackThread(const RosCallbackThread&) = delete;
  RosCallbackThread& operator=(const RosCallbackThread&) = delete;

  /// A handle whose callbacks come in this thread.
  ros::NodeHandle node(const std::string& name_space = "") {
    ros::NodeHandle node(name_space);
    node.setCallbackQueue(&queue_);
    return node;
  }
  /// What is kept from now on is kept for `owner`.
  void keep_for(const void* owner) { owner_ = owner; }
  /// Keeps a subscriber, publisher, server or listener as long as the thread lives, or until drop().
  template <class Part>
  void keep(Part part) {
    kept_.emplace_back(owner_, std::move(part));
  }
  /// Gives up what is kept for `owner`, which is not called any more. May wait for the master.
  void drop(const void* owner) {
    const auto is_its = [&](const auto& part) { return part.first == owner; };
    kept_.erase(std::remove_if(kept_.begin(), kept_.end(), is_its), kept_.end());
  }
  /// Calls use(message pointer) for each message of a topic.
  template <class Message, class Use>
  void subscribe(const std::string& topic, std::uint32_t queue_size, Use use,
                 const ros::TransportHints& hints = {}) {
    const boost::function<void(const boost::shared_ptr<const Message>&)> callback = std::move(use);
    keep(node().subscribe<Message>(topic, queue_size, callback, {}, hints));
  }
  /// Nobody is called any more.
  void stop() {
    queue_.disable();
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }

 private:
  void run(RosPulse& pulse) {
    while (!stopping_) {
      pulse.tick(RosPulse::callbacks);
      queue_.callAvailable(ros::WallDuration(0.1));
    }
  }

  ros::CallbackQueue queue_;
  std::vector<std::pair<const void*, std::any>> kept_;
  const void* owner_ = nullptr;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace lidard
