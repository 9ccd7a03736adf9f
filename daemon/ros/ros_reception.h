// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/callback_queue.h>
#include <ros/node_handle.h>
#include <ros/spinner.h>

#include <memory>
#include <utility>
#include <vector>

namespace lidard {

/// What those who take messages or requests need of ROS, with a thread of their own: created when it runs,
/// gone before it ends.
struct RosReception {
  ros::CallbackQueue queue;
  ros::NodeHandle node;
  ros::AsyncSpinner spinner{1, &queue};
  std::vector<ros::Publisher> publishers;
  std::vector<ros::Subscriber> subscribers;
  std::vector<ros::ServiceServer> services;

  RosReception() {
    node.setCallbackQueue(&queue);
    spinner.start();
  }
  /// Ends it. With `leave` roscpp must not be told, whose destructors would wait for the master: it is kept,
  /// silent.
  static void end(std::unique_ptr<RosReception>& reception, bool leave) {
    static auto* const left = new std::vector<std::unique_ptr<RosReception>>;
    if (leave && reception) {
      reception->spinner.stop();
      left->push_back(std::move(reception));
    }
    reception.reset();
  }
};

}  // namespace lidard
