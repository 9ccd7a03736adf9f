// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause

#include <chrono>
#include <cstdlib>
#include <thread>

#include "daemon/config/config.h"
#include "daemon/dropin/dropin.h"
#include "daemon/log/log.h"
#include "daemon/ros/master/environment.h"
#include "daemon/ros/master/master_client.h"

namespace lidard {
namespace {

using XmlRpc::XmlRpcValue;

/// The value of the last argument `key`:=value.
std::string argument(const std::vector<std::string>& arguments, const std::string& key,
                     const std::string& missing) {
  std::string value = missing;
  for (const auto& given : arguments) {
    if (given.compare(0, key.size() + 2, key + ":=") == 0) value = given.substr(key.size() + 2);
  }
  return value;
}

bool as_text(XmlRpcValue& value, std::string& text);

bool list_as_text(XmlRpcValue& list, std::string& text) {
  for (int i = 0; i < list.size(); ++i) {
    std::string word;
    if (!as_text(list[i], word)) return false;
    text += (i == 0 ? "" : " ") + word;
  }
  return true;
}

/// A scalar, or scalars of a list, as text; false for dictionaries and binary data.
bool as_text(XmlRpcValue& value, std::string& text) {
  switch (value.getType()) {
    case XmlRpcValue::TypeBoolean:
      text = static_cast<bool&>(value) ? "true" : "false";
      return true;
    case XmlRpcValue::TypeInt:
      text = std::to_string(static_cast<int&>(value));
      return true;
    case XmlRpcValue::TypeDouble:
      text = fmt::format("{}", static_cast<double&>(value));
      return true;
    case XmlRpcValue::TypeString:
      text = static_cast<std::string&>(value);
      return true;
    case XmlRpcValue::TypeArray:
      return list_as_text(value, text);
    default:
      return false;
  }
}

NodeParameters scalars(XmlRpcValue& all) {
  NodeParameters parameters;
  if (all.getType() != XmlRpcValue::TypeStruct) return parameters;
  for (auto& [name, value] : all) {
    std::string text;
    if (as_text(value, text))
      parameters[name] = text;
    else
      log_warn("parameter ~{} is neither a value nor a list of values and has no effect", name);
  }
  return parameters;
}

}  // namespace

std::string full_node_name(const std::vector<std::string>& arguments, const std::string& name) {
  const char* const inherited = std::getenv("ROS_NAMESPACE");
  std::string space = argument(arguments, "__ns", inherited == nullptr ? "" : inherited);
  while (!space.empty() && space.front() == '/') space.erase(0, 1);
  while (!space.empty() && space.back() == '/') space.pop_back();
  return (space.empty() ? "/" : "/" + space + "/") + argument(arguments, "__name", name);
}

NodeParameters wait_for_parameters(const std::vector<std::string>& arguments, const std::string& node) {
  MasterClient master(*parse_server_uri(choose_master(arguments)), node);
  bool logged = false;
  std::optional<XmlRpcValue> all;
  while (!(all = master.parameters(node))) {
    if (!logged) log_warn("waiting for the ROS master, which holds the parameters: {}", master.error());
    logged = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }
  NodeParameters parameters = scalars(*all);
  for (const auto& given : arguments) {
    const auto at = given.find(":=");
    if (given.size() > 2 && given[0] == '_' && given[1] != '_' && at != std::string::npos)
      parameters[given.substr(1, at - 1)] = given.substr(at + 2);
  }
  return parameters;
}

}  // namespace lidard
