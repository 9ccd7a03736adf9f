// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/velodyne_node.h"

#include <spdlog/spdlog.h>

#include <csignal>
#include <ostream>
#include <thread>

#include "daemon/cli.h"
#include "daemon/config.h"
#include "daemon/node_parameters.h"
#include "daemon/ros_link.h"
#include "daemon/run.h"
#include "daemon/service.h"

namespace lidard {
namespace {

constexpr const char* usage =
    "Stands in for the nodes of ros-drivers/velodyne: reads their private parameters (model, device_ip, "
    "port, "
    "pcap, calibration, min_range, max_range, ...) and publishes velodyne_points and scan.\n"
    "usage: velodyne_node [_PARAMETER:=VALUE]... [FROM:=TO]...\n";

bool asks_for_help(const std::vector<std::string>& arguments) {
  for (const auto& argument : arguments) {
    if (argument == "--help" || argument == "-h") return true;
  }
  return false;
}

/// What is neither a remapping nor a parameter; empty if there is nothing.
std::string strange_argument(const std::vector<std::string>& arguments) {
  for (const auto& argument : arguments) {
    if (argument.find(":=") == std::string::npos) return argument;
  }
  return {};
}

int run_setup(VelodyneNodeSetup setup, const std::vector<std::string>& arguments, const std::string& node,
              std::ostream& out, std::ostream& err) {
  for (const auto& warning : setup.warnings) spdlog::warn("{}", warning);
  spdlog::info("the same as a configuration for `lidard run`:\n{}", setup.yaml);
  const Config config = parse_config(setup.yaml, "parameters of " + node);
  if (setup.replay.captures.empty()) return run_daemon(config, arguments, velodyne_node_name, err);
  setup.replay.ros_arguments = arguments;
  setup.replay.node_name = velodyne_node_name;
  return run_replay(setup.replay, config, out, err);
}

}  // namespace

int run_velodyne_node(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
  if (asks_for_help(arguments)) {
    out << usage;
    return exit_ok;
  }
  if (const std::string strange = strange_argument(arguments); !strange.empty()) {
    err << "'" << strange << "' is no parameter and no remapping\n" << usage;
    return exit_usage;
  }
  set_up_logging();
  try {
    const std::string node = full_node_name(arguments, velodyne_node_name);
    return run_setup(velodyne_node_setup(wait_for_parameters(arguments, node)), arguments, node, out, err);
  } catch (const ConfigError& e) {
    err << e.what() << '\n';
    return exit_config;
  } catch (const RosError& e) {
    err << e.what() << '\n';
    return exit_usage;
  }
}

}  // namespace lidard
