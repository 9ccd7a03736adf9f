// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/velodyne_node.h"

#include <spdlog/spdlog.h>

#include "daemon/commands/run.h"
#include "daemon/config/config.h"
#include "daemon/dropin/dropin_node.h"
#include "daemon/dropin/node_parameters.h"

namespace lidard {
namespace {

constexpr const char* usage =
    "Stands in for the nodes of ros-drivers/velodyne: reads their private parameters (model, device_ip, "
    "port, "
    "pcap, calibration, min_range, max_range, ...) and publishes velodyne_points and scan.\n"
    "usage: velodyne_node [_PARAMETER:=VALUE]... [FROM:=TO]...\n";

int run_setup(VelodyneNodeSetup setup, const DropinCall& call) {
  for (const auto& warning : setup.warnings) spdlog::warn("{}", warning);
  spdlog::info("the same as a configuration for `lidard run`:\n{}", setup.yaml);
  const Config config = parse_config(setup.yaml, "parameters of " + call.node);
  const RosOptions ros{velodyne_node_name, call.arguments};
  if (setup.replay.captures.empty()) return run_daemon(config, ros, call.err);
  setup.replay.ros = ros;
  return run_replay(setup.replay, config, call.out, call.err);
}

}  // namespace

int run_velodyne_node(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
  return run_dropin(velodyne_node_name, usage, arguments, out, err, [](const DropinCall& call) {
    return run_setup(velodyne_node_setup(wait_for_parameters(call.arguments, call.node)), call);
  });
}

}  // namespace lidard
