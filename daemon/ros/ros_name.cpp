// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/ros_name.h"

#include <ros/xmlrpc_manager.h>
#include <spdlog/spdlog.h>

#include <charconv>
#include <utility>

#include "daemon/ros/ros_master.h"

namespace lidard {
namespace {

using std::chrono::seconds;
using Clock = std::chrono::steady_clock;
using XmlRpc::XmlRpcValue;

/// A method of our own beside those of ROS's Slave API.
constexpr const char* method = "lidard_started";
/// A daemon that is just being stopped has left the master by then.
constexpr auto patience = seconds(3);
constexpr auto takeover_window = seconds(10);
constexpr std::size_t most_takeovers = 3;
/// Two daemons that start in step throw each other out in step, and neither is there when the other one asks.
/// Of two that step aside by chance, one finds the other.
constexpr Span longest_step_aside = std::chrono::seconds(1);
/// Pause where a node that is no daemon of ours takes the name again and again.
constexpr auto back_off = seconds(5);

/// The answer of `method`: [1, node name, nanoseconds since the epoch as text, since XML-RPC has 32 bits].
std::optional<Stamp> start_in(XmlRpcValue& answer, const std::string& node) {
  if (answer.getType() != XmlRpcValue::TypeArray || answer.size() != 3) return std::nullopt;
  for (const int i : {1, 2}) {
    if (answer[i].getType() != XmlRpcValue::TypeString) return std::nullopt;
  }
  if (static_cast<std::string&>(answer[1]) != node) return std::nullopt;
  const auto& text = static_cast<std::string&>(answer[2]);
  Stamp started;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), started.ns);
  if (read.ec != std::errc() || read.ptr != text.data() + text.size()) return std::nullopt;
  return started;
}

}  // namespace

RosName::RosName(std::string node, Stamp started) : node_(std::move(node)), started_(started) {}

void RosName::answer_others() {
  ros::XMLRPCManager::instance()->bind(method,
                                       [node = node_, started = started_](XmlRpcValue&, XmlRpcValue& result) {
                                         result[0] = 1;
                                         result[1] = node;
                                         result[2] = std::to_string(started.ns);
                                       });
}

std::optional<RosName::Holder> RosName::holder(MasterClient& master) const {
  const auto uri = master.node_uri(node_);
  const auto server = uri ? parse_server_uri(*uri) : std::nullopt;
  if (!server) return std::nullopt;
  XmlRpcValue arguments;
  arguments[0] = node_;
  std::string error;
  auto answer = xmlrpc_call(*server, method, arguments, std::chrono::milliseconds(500), error);
  const auto started = answer ? start_in(*answer, node_) : std::nullopt;
  if (!started) return std::nullopt;
  return Holder{*uri, *started};
}

bool RosName::is_free(MasterClient& master) {
  if (!conflict().empty()) return false;
  if (ours_) return true;
  const auto other = holder(master);
  if (!other) {
    seen_since_.reset();
    return true;
  }
  if (!seen_since_) {
    spdlog::warn("another daemon at {} has the node name {}; waiting for its end", other->uri, node_);
    seen_since_ = Clock::now();
  }
  if (Clock::now() - *seen_since_ >= patience) give_up(*other);
  return false;
}

Span RosName::thrown_out() {
  const auto now = Clock::now();
  thrown_out_.push_back(now);
  while (now - thrown_out_.front() > takeover_window) thrown_out_.pop_front();
  if (thrown_out_.size() < most_takeovers) return Span(0);
  return Span(std::uniform_int_distribution<Span::rep>(0, longest_step_aside.count())(chance_));
}

Span RosName::after_thrown_out(MasterClient& master) {
  if (thrown_out_.size() < most_takeovers) return Span(0);
  const auto other = holder(master);
  if (!other) return thrown_out_.size() > most_takeovers ? Span(back_off) : Span(0);
  if (other->started < started_) give_up(*other);
  return Span(0);
}

void RosName::give_up(const Holder& other) {
  const std::lock_guard lock(mutex_);
  conflict_ = "another daemon, at " + other.uri + ", has the node name " + node_ +
              " and was first; two nodes of one name shut each other down. Stop the other one, or give this "
              "one another name: __name:=" +
              node_.substr(node_.rfind('/') + 1) + "_2";
}

std::string RosName::conflict() const {
  const std::lock_guard lock(mutex_);
  return conflict_;
}

}  // namespace lidard
