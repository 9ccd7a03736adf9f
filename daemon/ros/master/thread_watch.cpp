// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/master/thread_watch.h"

#include <ros/callback_queue.h>
#include <ros/init.h>
#include <ros/poll_manager.h>
#include <ros/xmlrpc_manager.h>

#include <utility>

#include "daemon/live/thread_priority.h"

namespace ros {
// Exported, but in no header; roscpp's own transport_publisher_link.cpp declares it in the same way.
CallbackQueuePtr getInternalCallbackQueue();
}  // namespace ros

namespace lidard {
namespace {

/// A longer call into roscpp waits for the master.
constexpr auto quick_call = std::chrono::milliseconds(300);

struct Names {
  const char* for_debuggers;  // roscpp leaves its threads without names
  const char* for_people;
};
constexpr Names names[] = {{"lidard-ros", "the ROS thread"},
                           {"lidard-callback", "the thread for ROS callbacks"},
                           {"roscpp-sockets", "roscpp's thread for sockets"},
                           {"roscpp-xmlrpc", "roscpp's thread for XML-RPC"},
                           {"roscpp-callback", "roscpp's thread for callbacks"},
                           {"lidard-master", "the thread that talks to the ROS master"}};

}  // namespace

void ThreadWatch::Rounds::tick(Thread thread) {
  thread_local bool named = false;
  if (!std::exchange(named, true)) name_this_thread(names[thread].for_debuggers);
  ++counts[thread];
  last[thread] = Clock::now();
}

/// A connection without a socket: the server's thread checks in each round whether each connection has ended.
class ThreadWatch::ServerRound final : public ros::ASyncXMLRPCConnection {
 public:
  explicit ServerRound(std::shared_ptr<Rounds> rounds) : rounds_(std::move(rounds)) {}
  void addToDispatch(XmlRpc::XmlRpcDispatch*) override {}
  void removeFromDispatch(XmlRpc::XmlRpcDispatch*) override {}
  bool check() override {
    rounds_->tick(server);
    return false;
  }

 private:
  std::shared_ptr<Rounds> rounds_;
};

class ThreadWatch::InternalRound final : public ros::CallbackInterface {
 public:
  explicit InternalRound(std::shared_ptr<Rounds> rounds) : rounds_(std::move(rounds)) {}
  CallResult call() override {
    rounds_->tick(internal);
    rounds_->callback_waits = false;
    return Success;
  }

 private:
  std::shared_ptr<Rounds> rounds_;
};

void ThreadWatch::attach() {
  rounds_->callback_waits = false;
  ros::XMLRPCManager::instance()->addASyncConnection(boost::make_shared<ServerRound>(rounds_));
  const ros::CallbackInterfacePtr callback = boost::make_shared<InternalRound>(rounds_);
  ros::PollManager::instance()->addPollThreadListener([rounds = rounds_, callback] {
    rounds->tick(sockets);
    if (!rounds->callback_waits.exchange(true)) ros::getInternalCallbackQueue()->addCallback(callback);
  });
  attached_ = true;
}

std::string ThreadWatch::standing(bool master_answers) {
  const auto called = called_.load();
  const bool waits = called != Clock::time_point() && Clock::now() - called > quick_call;
  if (waits || ros::isShuttingDown()) return {};
  std::array<std::uint64_t, threads> now{};
  std::string standing;
  for (std::size_t i = 0; i < threads; ++i) {
    now[i] = rounds_->counts[i];
    const bool ours = i == publishing || i == master;
    const bool without_master = i <= callbacks;
    const bool counts = (ours ? now[i] > 0 : attached_.load()) && (without_master || master_answers);
    if (counts && now[i] == before_[i])
      standing += (standing.empty() ? "" : ", ") + std::string(names[i].for_people);
  }
  if (standing.empty()) before_ = now;
  return standing;
}

}  // namespace lidard
