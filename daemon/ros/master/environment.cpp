// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/ros/master/environment.h"

#include <ros/exceptions.h>
#include <ros/init.h>
#include <ros/names.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>

#include "daemon/log/log.h"
#include "daemon/ros/master/xmlrpc.h"
#include "drivers/net/host_network.h"

namespace lidard {
namespace {

/// Empty if the variable is not set.
std::string value_of(const char* variable) {
  const char* const value = std::getenv(variable);
  return value == nullptr ? "" : value;
}

bool may_write_below(const std::string& home) {
  const std::string folder = home + "/.ros";
  return access(folder.c_str(), F_OK) == 0 ? access(folder.c_str(), W_OK | X_OK) == 0
                                           : access(home.c_str(), W_OK | X_OK) == 0;
}

RosError wrong_name(const ros::Exception& problem) {
  return RosError(std::string(problem.what()) + "; expected names of letters, digits, _ and /");
}

/// The IPv4 address of a host, if it is known within a second: a name server may be out of reach.
std::optional<IpAddress> address_of(const std::string& name) {
  for (const std::string& text : resolve(name, std::chrono::seconds(1))) {
    const auto address = IpAddress::parse(text);
    if (address && !address->v6) return address;
  }
  return std::nullopt;
}

}  // namespace

std::string own_address_warning() {
  const char* const variable = value_of("ROS_HOSTNAME").empty() ? "ROS_IP" : "ROS_HOSTNAME";
  const std::string given = value_of(variable);
  if (given.empty()) return {};
  const auto address = address_of(given);
  const std::string given_address = std::string(variable) + " is " + given + ", which ";
  if (!address)
    return given_address + "no name server resolves: other nodes cannot reach what is published here";
  if (address->to_string().compare(0, 4, "127.") == 0 || address->v6) return {};
  std::string own;
  for (const HostInterface& one : read_network().interfaces) {
    if (one.prefix == 0) continue;
    if (one.address == *address) return {};
    own.append(own.empty() ? "" : ", ").append(one.to_string());
  }
  return given_address +
         "no interface of this host has: other nodes cannot reach what is published here; expected one of " +
         own + ", or neither ROS_IP nor ROS_HOSTNAME";
}

void init_ros(const RosOptions& options) {
  ros::M_string remappings;
  for (const auto& remapping : options.remappings) {
    const auto at = remapping.find(":=");
    if (at == std::string::npos || at == 0)
      throw RosError("'" + remapping + "' is not a remapping; expected from:=to");
    remappings[remapping.substr(0, at)] = remapping.substr(at + 2);
  }
  choose_ros_log_folder();
  if (const std::string warning = own_address_warning(); !warning.empty()) log_warn("{}", warning);
  try {
    // lidard does not use /rosout, whose thread would wait for the master.
    ros::init(remappings, options.node_name,
              ros::init_options::NoSigintHandler | ros::init_options::NoRosout);
  } catch (const ros::Exception& problem) {
    throw wrong_name(problem);
  }
}

void check_ros_names(const std::vector<OutputTopic>& topics) {
  try {
    for (const auto& topic : topics) ros::names::resolve(topic.name);
  } catch (const ros::Exception& problem) {
    throw wrong_name(problem);
  }
}

void choose_ros_log_folder() {
  if (!value_of("ROS_LOG_DIR").empty() || !value_of("ROS_HOME").empty() || std::getenv("HOME") == nullptr)
    return;
  if (may_write_below(value_of("HOME"))) return;
  std::error_code error;
  const auto temporary = std::filesystem::temp_directory_path(error);
  std::string folder = value_of("RUNTIME_DIRECTORY");
  if (folder.empty()) folder = error ? "/tmp" : temporary.string();
  setenv("ROS_LOG_DIR", folder.c_str(), 1);
}

std::string choose_master(const std::vector<std::string>& remappings) {
  std::string uri = value_of("ROS_MASTER_URI");
  if (uri.empty()) uri = "http://localhost:11311";
  const std::string remapping = "__master:=";
  for (const auto& given : remappings) {
    if (given.compare(0, remapping.size(), remapping) == 0) uri = given.substr(remapping.size());
  }
  if (!parse_server_uri(uri))
    throw RosError("the ROS master's address is '" + uri +
                   "'; expected http://host:port in ROS_MASTER_URI, e.g. http://localhost:11311");
  setenv("ROS_MASTER_URI", uri.c_str(), 1);
  return uri;
}

}  // namespace lidard
