// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ros/master/xmlrpc.h"

namespace lidard {

/// The ROS master (Master API, wiki.ros.org/ROS/Master_API), asked with a time limit.
class MasterClient {
 public:
  MasterClient(XmlRpcServer server, std::string caller_id, Span limit = std::chrono::milliseconds(500));

  /// The master's process; changes when it is restarted. Empty: no answer.
  std::optional<int> pid();
  /// Registers a topic that roscpp publishes in this process.
  bool register_publisher(const std::string& topic, const std::string& type);
  bool register_service(const std::string& service, std::uint32_t port);
  /// Registers this node, and passes the publishers of the topic to roscpp, as the master does for a new one.
  bool register_subscriber(const std::string& topic);
  /// Address of a node's XML-RPC server; empty: no node of that name is registered, or no answer.
  std::optional<std::string> node_uri(const std::string& node);
  /// Types by topic, of all topics the master knows; empty without an answer.
  std::map<std::string, std::string> topic_types();

  /// The parameters below a name, a struct that is empty where there are none; nothing without an answer.
  std::optional<XmlRpc::XmlRpcValue> parameters(const std::string& name);

  bool set_parameter(const std::string& name, const XmlRpc::XmlRpcValue& value);

  const std::string& caller_id() const { return caller_id_; }
  /// Why the last call had no answer.
  const std::string& error() const { return error_; }

 private:
  std::optional<XmlRpc::XmlRpcValue> call(const std::string& method,
                                          const std::vector<std::string>& arguments);
  std::optional<XmlRpc::XmlRpcValue> ask(const std::string& method, const XmlRpc::XmlRpcValue& arguments);

  XmlRpcServer server_;
  std::string caller_id_;
  Span limit_;
  std::string error_;
};

/// Registers all topics and services of this process that roscpp knows at a (restarted) master; roscpp
/// registers only once. `services`: this node's, by full name. `port`: roscpp's port for services; asking
/// roscpp for it during its shutdown would end the process. False if the master did not answer every call.
bool register_again(MasterClient& master, const std::vector<std::string>& services, std::uint32_t port);

}  // namespace lidard
