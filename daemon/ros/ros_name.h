// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/xmlrpc_manager.h>

#include <charconv>
#include <chrono>
#include <deque>
#include <mutex>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include "core/base/time.h"
#include "daemon/pipeline/log.h"
#include "daemon/ros/ros_master.h"

namespace lidard {

/// Two daemons of one node name would shut each other down for ever: the master ends the older registration
/// with each new one. The first daemon keeps the name, the second one gives up. Calls belong to the master
/// thread, except conflict().
class RosName {
 public:
  /// `started`: when this process began; tells who of two is the first where both have registered.
  RosName(std::string node, Stamp started) : node_(std::move(node)), started_(started) {}

  /// Lets other daemons ask us since when we run. To be called before each ros::start().
  void answer_others() {
    ros::XMLRPCManager::instance()->bind(
        method, [node = node_, started = started_](XmlRpc::XmlRpcValue&, XmlRpc::XmlRpcValue& result) {
          result[0] = 1;
          result[1] = node;
          result[2] = std::to_string(started.ns);
        });
  }
  /// False while another daemon holds the name; when it still does so after 3 s, we give up.
  bool is_free(MasterClient& master) {
    if (!conflict().empty()) return false;
    if (ours_) return true;
    const auto other = holder(master);
    if (!other) {
      seen_since_.reset();
      return true;
    }
    if (!seen_since_) {
      log_warn("another daemon at {} has the node name {}; waiting for its end", other->uri, node_);
      seen_since_ = Clock::now();
    }
    if (Clock::now() - *seen_since_ >= patience) give_up(*other);
    return false;
  }
  /// We have registered: from now on the name is ours, and another one that takes it comes second.
  void taken() { ours_ = true; }
  /// We were shut down from outside. Returns how long to step aside, so that another daemon can settle.
  Span thrown_out() {
    const auto now = Clock::now();
    thrown_out_.push_back(now);
    while (now - thrown_out_.front() > takeover_window) thrown_out_.pop_front();
    if (thrown_out_.size() < most_takeovers) return Span(0);
    return Span(std::uniform_int_distribution<Span::rep>(0, longest_step_aside.count())(chance_));
  }
  /// To be called then: after three times in 10 s we give up if the daemon that has the name now started
  /// before us. Returns how long to wait before we start again.
  Span after_thrown_out(MasterClient& master) {
    if (thrown_out_.size() < most_takeovers) return Span(0);
    const auto other = holder(master);
    if (!other) return thrown_out_.size() > most_takeovers ? Span(back_off) : Span(0);
    if (other->started < started_) give_up(*other);
    return Span(0);
  }
  /// Why we have given up, with the remedy; empty: we have not.
  std::string conflict() const {
    const std::lock_guard lock(mutex_);
    return conflict_;
  }

 private:
  using Clock = std::chrono::steady_clock;
  /// A method of our own beside those of ROS's Slave API.
  static constexpr const char* method = "lidard_started";
  /// A daemon that is just being stopped has left the master by then.
  static constexpr auto patience = std::chrono::seconds(3);
  static constexpr auto takeover_window = std::chrono::seconds(10);
  static constexpr std::size_t most_takeovers = 3;
  /// Two daemons that start in step throw each other out in step, and neither is there when the other one
  /// asks. Of two that step aside by chance, one finds the other.
  static constexpr Span longest_step_aside = std::chrono::seconds(1);
  /// Pause where a node that is no daemon of ours takes the name again and again.
  static constexpr auto back_off = std::chrono::seconds(5);
  /// The answer of `method`: [1, node name, nanoseconds since the epoch as text, since XML-RPC has 32 bits].
  static std::optional<Stamp> start_in(XmlRpc::XmlRpcValue& answer, const std::string& node) {
    if (answer.getType() != XmlRpc::XmlRpcValue::TypeArray || answer.size() != 3) return std::nullopt;
    for (const int i : {1, 2}) {
      if (answer[i].getType() != XmlRpc::XmlRpcValue::TypeString) return std::nullopt;
    }
    if (static_cast<std::string&>(answer[1]) != node) return std::nullopt;
    const auto& text = static_cast<std::string&>(answer[2]);
    Stamp started;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), started.ns);
    if (read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
    return started;
  }
  struct Holder {
    std::string uri;
    Stamp started;
  };
  std::optional<Holder> holder(MasterClient& master) const {
    const auto uri = master.node_uri(node_);
    const auto server = uri ? parse_server_uri(*uri) : std::nullopt;
    if (!server) return std::nullopt;
    XmlRpc::XmlRpcValue arguments;
    arguments[0] = node_;
    std::string error;
    auto answer = xmlrpc_call(*server, method, arguments, std::chrono::milliseconds(500), error);
    const auto started = answer ? start_in(*answer, node_) : std::nullopt;
    if (!started) return std::nullopt;
    return Holder{*uri, *started};
  }
  void give_up(const Holder& other) {
    const std::lock_guard lock(mutex_);
    conflict_ =
        "another daemon, at " + other.uri + ", has the node name " + node_ +
        " and was first; two nodes of one name shut each other down. Stop the other one, or give this "
        "one another name: __name:=" +
        node_.substr(node_.rfind('/') + 1) + "_2";
  }

  const std::string node_;
  const Stamp started_;
  bool ours_ = false;
  std::optional<Clock::time_point> seen_since_;
  std::deque<Clock::time_point> thrown_out_;
  std::minstd_rand chance_{std::random_device{}()};
  mutable std::mutex mutex_;
  std::string conflict_;
};

}  // namespace lidard
