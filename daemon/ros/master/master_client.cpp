// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/master/master_client.h"

#include <ros/network.h>
#include <ros/publication.h>
#include <ros/this_node.h>
#include <ros/topic_manager.h>
#include <ros/xmlrpc_manager.h>

#include <utility>

namespace lidard {
namespace {

using XmlRpc::XmlRpcValue;

std::vector<std::string> strings(XmlRpcValue& list) {
  std::vector<std::string> found;
  if (list.getType() != XmlRpcValue::TypeArray) return found;
  for (int i = 0; i < list.size(); ++i) {
    if (list[i].getType() == XmlRpcValue::TypeString) found.push_back(static_cast<std::string&>(list[i]));
  }
  return found;
}

/// Address of roscpp in this process.
std::string our_uri() { return ros::XMLRPCManager::instance()->getServerURI(); }

}  // namespace

MasterClient::MasterClient(XmlRpcServer server, std::string caller_id, Span limit)
    : server_(std::move(server)), caller_id_(std::move(caller_id)), limit_(limit) {}

std::optional<XmlRpcValue> MasterClient::call(const std::string& method,
                                              const std::vector<std::string>& arguments) {
  XmlRpcValue list;
  list[0] = caller_id_;
  for (std::size_t i = 0; i < arguments.size(); ++i) list[static_cast<int>(i + 1)] = arguments[i];
  return ask(method, list);
}

std::optional<XmlRpcValue> MasterClient::ask(const std::string& method, const XmlRpcValue& arguments) {
  auto answer = xmlrpc_call(server_, method, arguments, limit_, error_);
  if (!answer) return std::nullopt;
  // Every answer of the master is [code, message, value]; code 1 is success (Master API).
  if (answer->getType() != XmlRpcValue::TypeArray || answer->size() != 3 ||
      (*answer)[0].getType() != XmlRpcValue::TypeInt || static_cast<int&>((*answer)[0]) != 1) {
    error_ = method + ": the master refused";
    return std::nullopt;
  }
  return XmlRpcValue((*answer)[2]);
}

std::optional<int> MasterClient::pid() {
  auto value = call("getPid", {});
  if (!value || value->getType() != XmlRpcValue::TypeInt) return std::nullopt;
  return static_cast<int&>(*value);
}

bool MasterClient::register_publisher(const std::string& topic, const std::string& type) {
  return call("registerPublisher", {topic, type, our_uri()}).has_value();
}

bool MasterClient::register_service(const std::string& service, std::uint32_t port) {
  const std::string service_uri = "rosrpc://" + ros::network::getHost() + ":" + std::to_string(port);
  return call("registerService", {service, service_uri, our_uri()}).has_value();
}

bool MasterClient::register_subscriber(const std::string& topic) {
  auto publishers = call("registerSubscriber", {topic, "*", our_uri()});
  const auto us = parse_server_uri(our_uri());
  if (!publishers || !us) return publishers.has_value();
  if (publishers->getType() != XmlRpcValue::TypeArray || publishers->size() == 0) return true;
  XmlRpcValue arguments;
  arguments[0] = caller_id_;
  arguments[1] = topic;
  arguments[2] = *publishers;
  std::string error;
  xmlrpc_call(*us, "publisherUpdate", arguments, std::chrono::milliseconds(500), error);
  return true;
}

std::optional<std::string> MasterClient::node_uri(const std::string& node) {
  auto value = call("lookupNode", {node});
  if (!value || value->getType() != XmlRpcValue::TypeString) return std::nullopt;
  return static_cast<std::string&>(*value);
}

std::map<std::string, std::string> MasterClient::topic_types() {
  std::map<std::string, std::string> types;
  auto value = call("getTopicTypes", {});
  if (!value || value->getType() != XmlRpcValue::TypeArray) return types;
  for (int i = 0; i < value->size(); ++i) {
    const auto pair = strings((*value)[i]);
    if (pair.size() == 2) types[pair[0]] = pair[1];
  }
  return types;
}

std::optional<XmlRpcValue> MasterClient::parameters(const std::string& name) {
  // getParam fails in the same way for a missing parameter and for an error.
  auto there = call("hasParam", {name});
  if (!there || there->getType() != XmlRpcValue::TypeBoolean) return std::nullopt;
  if (!static_cast<bool&>(*there)) {
    XmlRpcValue none;
    none.begin();  // makes it a struct
    return none;
  }
  return call("getParam", {name});
}

bool MasterClient::set_parameter(const std::string& name, const XmlRpcValue& value) {
  XmlRpcValue arguments;
  arguments[0] = caller_id_;
  arguments[1] = name;
  arguments[2] = value;
  return ask("setParam", arguments).has_value();
}

bool register_again(MasterClient& master, const std::vector<std::string>& services, std::uint32_t port) {
  ros::V_string published;
  ros::V_string subscribed;
  ros::this_node::getAdvertisedTopics(published);
  ros::this_node::getSubscribedTopics(subscribed);
  bool all = true;
  for (const auto& topic : published) {
    const auto publication = ros::TopicManager::instance()->lookupPublication(topic);
    if (publication) all &= master.register_publisher(topic, publication->getDataType());
  }
  for (const auto& topic : subscribed) all &= master.register_subscriber(topic);
  // roscpp offers these two for every node.
  for (const char* name : {"/get_loggers", "/set_logger_level"})
    all &= master.register_service(master.caller_id() + name, port);
  for (const auto& service : services) all &= master.register_service(service, port);
  return all;
}

}  // namespace lidard
