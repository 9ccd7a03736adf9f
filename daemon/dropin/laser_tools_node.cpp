// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/laser_tools_node.h"

#include <spdlog/spdlog.h>

#include "daemon/commands/run.h"
#include "daemon/config/config.h"
#include "daemon/dropin/dropin_node.h"

namespace lidard {
namespace {

// ira_laser_tools' name for the node, which differs from that of its executable.
constexpr const char* merger_name = "laser_multi_merger";
constexpr const char* virtualizer_name = "laserscan_virtualizer";

constexpr const char* merger_usage =
    "Stands in for laserscan_multi_merger of ira_laser_tools: reads its private parameters "
    "(laserscan_topics, "
    "destination_frame, ...) and publishes the merged scan and cloud.\n"
    "usage: laserscan_multi_merger [_PARAMETER:=VALUE]... [FROM:=TO]...\n";
constexpr const char* virtualizer_usage =
    "Stands in for laserscan_virtualizer of ira_laser_tools: reads its parameters (cloud_topic, "
    "virtual_laser_scan, ...) and publishes a scan for each virtual frame.\n"
    "usage: laserscan_virtualizer [_PARAMETER:=VALUE]... [FROM:=TO]...\n";

int run_setup(const LaserToolsSetup& setup, const char* name, const DropinCall& call) {
  for (const auto& warning : setup.warnings) spdlog::warn("{}", warning);
  spdlog::info("the same as a configuration for `lidard run`:\n{}", setup.yaml);
  const Config config = parse_config(setup.yaml, "parameters of " + call.node);
  return run_daemon(config, {name, call.arguments, ReconfigureNames::node}, call.err);
}

}  // namespace

int run_laser_merger(const std::vector<std::string>& ros_arguments, std::ostream& out, std::ostream& err) {
  return run_dropin(merger_name, merger_usage, ros_arguments, out, err, [](const DropinCall& call) {
    return run_setup(laser_merger_setup(wait_for_parameters(call.arguments, call.node)), merger_name, call);
  });
}

int run_laser_virtualizer(const std::vector<std::string>& ros_arguments, std::ostream& out,
                          std::ostream& err) {
  return run_dropin(virtualizer_name, virtualizer_usage, ros_arguments, out, err, [](const DropinCall& call) {
    const NodeParameters own = wait_for_parameters(call.arguments, call.node);
    const NodeParameters absolute = wait_for_parameters(call.arguments, std::string("/") + virtualizer_name);
    return run_setup(laser_virtualizer_setup(with_absolute_names(own, absolute)), virtualizer_name, call);
  });
}

}  // namespace lidard
