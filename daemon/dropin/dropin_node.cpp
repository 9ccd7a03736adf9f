// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/dropin_node.h"

#include <algorithm>
#include <ostream>

#include "daemon/config/config.h"
#include "daemon/config/exit_codes.h"
#include "daemon/dropin/laser_tools_node.h"
#include "daemon/dropin/node_parameters.h"
#include "daemon/dropin/velodyne_node.h"
#include "daemon/live/service.h"
#include "daemon/ros/ros_environment.h"

namespace lidard {
namespace {

bool asks_for_help(const std::string& argument) { return argument == "--help" || argument == "-h"; }
bool means_something(const std::string& argument) { return argument.find(":=") != std::string::npos; }

}  // namespace

int run_dropin(const char* name, const char* usage, const std::vector<std::string>& arguments,
               std::ostream& out, std::ostream& err, const std::function<int(const DropinCall&)>& body) {
  if (std::any_of(arguments.begin(), arguments.end(), asks_for_help)) {
    out << usage;
    return exit_ok;
  }
  const auto strange = std::find_if_not(arguments.begin(), arguments.end(), means_something);
  if (strange != arguments.end()) {
    err << "'" << *strange << "' is no parameter and no remapping\n" << usage;
    return exit_usage;
  }
  set_up_logging();
  try {
    return body({arguments, full_node_name(arguments, name), out, err});
  } catch (const ConfigError& e) {
    err << e.what() << '\n';
    return exit_config;
  } catch (const RosError& e) {
    err << e.what() << '\n';
    return exit_usage;
  }
}

std::function<int(const std::vector<std::string>&, std::ostream&, std::ostream&)> find_dropin(
    const std::string& executable) {
  if (executable == "velodyne_node") return run_velodyne_node;
  if (executable == "laserscan_multi_merger") return run_laser_merger;
  if (executable == "laserscan_virtualizer") return run_laser_virtualizer;
  return {};
}

}  // namespace lidard
