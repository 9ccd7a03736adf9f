// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <spdlog/spdlog.h>

#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <thread>

#include "core/base/nearest.h"
#include "daemon/config/config.h"
#include "daemon/dropin/dropin.h"
#include "daemon/ros/ros_environment.h"
#include "daemon/ros/ros_master.h"

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
      spdlog::warn("parameter ~{} is neither a value nor a list of values and has no effect", name);
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
  bool told = false;
  std::optional<XmlRpcValue> all;
  while (!(all = master.parameters(node))) {
    if (!told) spdlog::warn("waiting for the ROS master, which holds the parameters: {}", master.error());
    told = true;
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

std::optional<std::string> ParameterReader::find(const std::string& name) {
  known_.push_back(name);
  const auto found = left_.find(name);
  if (found == left_.end()) return std::nullopt;
  const std::string value = found->second;
  left_.erase(found);
  return value;
}

std::string ParameterReader::text(const std::string& name, const std::string& missing) {
  return find(name).value_or(missing);
}

double ParameterReader::number(const std::string& name, double missing) {
  const std::string given = text(name, "");
  if (given.empty()) return missing;
  double value = 0;
  const auto end = given.data() + given.size();
  const auto parsed = std::from_chars(given.data(), end, value);
  if (parsed.ec != std::errc() || parsed.ptr != end || !std::isfinite(value))
    throw ConfigError("parameter ~" + name + " is '" + given + "'; expected a number");
  return value;
}

bool ParameterReader::flag(const std::string& name) {
  const std::string given = text(name, "false");
  if (given == "true" || given == "1" || given == "True") return true;
  if (given == "false" || given == "0" || given == "False" || given.empty()) return false;
  throw ConfigError("parameter ~" + name + " is '" + given + "'; expected true or false");
}

void ParameterReader::remark_on_rest(std::vector<std::string>& warnings) const {
  const std::vector<std::string_view> names(known_.begin(), known_.end());
  for (const auto& [name, value] : left_) {
    const std::string near(nearest_word(name, names));
    warnings.push_back("parameter ~" + name + " is not known and has no effect" +
                       (near.empty() ? "" : "; did you mean ~" + near + "?"));
  }
}

}  // namespace lidard
