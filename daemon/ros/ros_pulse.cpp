// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_pulse.h"

#include <pthread.h>
#include <ros/callback_queue.h>
#include <ros/init.h>
#include <ros/param.h>
#include <ros/poll_manager.h>
#include <ros/xmlrpc_manager.h>

#include <utility>

namespace ros {
// Exported, but in no header; roscpp's own transport_publisher_link.cpp declares it in the same way.
CallbackQueuePtr getInternalCallbackQueue();
}  // namespace ros

namespace lidard {
namespace {

/// A call into roscpp that takes longer waits for the master.
constexpr auto quick_call = std::chrono::milliseconds(300);

/// For `top -H` and debuggers; roscpp leaves its threads without names.
void name_once(const char* name) {
  thread_local bool named = false;
  if (!named) name_this_thread(name);
  named = true;
}

}  // namespace

void name_this_thread(const char* name) { pthread_setname_np(pthread_self(), name); }

/// A connection without a socket: the server's thread asks each connection in each round whether it has
/// ended.
class RosPulse::ServerRound final : public ros::ASyncXMLRPCConnection {
 public:
  explicit ServerRound(std::shared_ptr<Counts> counts) : counts_(std::move(counts)) {}
  void addToDispatch(XmlRpc::XmlRpcDispatch*) override {}
  void removeFromDispatch(XmlRpc::XmlRpcDispatch*) override {}
  bool check() override {
    name_once("roscpp-xmlrpc");
    ++counts_->server;
    return false;
  }

 private:
  std::shared_ptr<Counts> counts_;
};

class RosPulse::CallbackRound final : public ros::CallbackInterface {
 public:
  explicit CallbackRound(std::shared_ptr<Counts> counts) : counts_(std::move(counts)) {}
  CallResult call() override {
    name_once("roscpp-callback");
    ++counts_->callbacks;
    counts_->callback_waits = false;
    return Success;
  }

 private:
  std::shared_ptr<Counts> counts_;
};

void RosPulse::tick() {
  ++ticks_;
  ticked_ = Clock::now();
}

void RosPulse::attach() {
  // Else roscpp asks the master for it in whatever thread first logs a warning, and hangs with the master.
  bool no_topics = false;
  ros::param::getCached("/rosout_disable_topics_generation", no_topics);
  counts_->callback_waits = false;
  ros::XMLRPCManager::instance()->addASyncConnection(boost::make_shared<ServerRound>(counts_));
  const ros::CallbackInterfacePtr callback = boost::make_shared<CallbackRound>(counts_);
  ros::PollManager::instance()->addPollThreadListener([counts = counts_, callback] {
    name_once("roscpp-sockets");
    ++counts->sockets;
    if (!counts->callback_waits.exchange(true)) ros::getInternalCallbackQueue()->addCallback(callback);
  });
  attached_ = true;
}

std::string RosPulse::standing(bool master_answers) {
  const auto called = called_.load();
  const bool waits = called != Clock::time_point() && Clock::now() - called > quick_call;
  if (waits || ros::isShuttingDown()) return {};
  const Rounds now{ticks_, counts_->sockets, counts_->server, counts_->callbacks};
  std::string standing;
  const auto add = [&standing](bool stands, const char* thread) {
    if (stands) standing += (standing.empty() ? "" : ", ") + std::string(thread);
  };
  add(now.ros == before_.ros, "the ROS thread");
  if (attached_ && master_answers) {
    add(now.sockets == before_.sockets, "roscpp's thread for sockets");
    add(now.server == before_.server, "roscpp's thread for XML-RPC");
    add(now.callbacks == before_.callbacks, "roscpp's thread for callbacks");
  }
  if (standing.empty()) before_ = now;
  return standing;
}

}  // namespace lidard
