// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <ostream>
#include <string_view>

#include "daemon/commands/commands.h"
#include "daemon/config/config.h"
#include "daemon/dropin/dropin.h"
#include "daemon/live/runtime_socket.h"
#include "daemon/log/log.h"
#include "daemon/ros/master/environment.h"

namespace lidard {
namespace {

using Arguments = std::vector<std::string>;

/// A node of another package.
struct Dropin {
  std::string_view executable;
  const char* node;   ///< default name
  const char* usage;  ///< text before the line on arguments
  ReconfigureNames reconfigure;
  DropinSetup (*setup)(const NodeParameters& parameters);
};

constexpr const char* virtualizer_name = "laserscan_virtualizer";

constexpr Dropin dropins[] = {
    {"velodyne_node", "velodyne_node",
     "Stands in for the nodes of ros-drivers/velodyne: reads their private parameters (model, device_ip, "
     "port, pcap, calibration, min_range, max_range, ...) and publishes velodyne_points and scan.\n",
     ReconfigureNames::node, velodyne_node_setup},
    {"sick_safetyscanners_node", "sick_safetyscanners",
     "Stands in for sick_safetyscanners_node: reads its private parameters (sensor_ip, host_ip, frame_id, "
     "...) and publishes scan, extended_laser_scan and output_paths.\n",
     ReconfigureNames::entries, safety_scanners_setup},
    {"urg_node", "urg_node",
     "Stands in for urg_node: reads its private parameters (ip_address, frame_id, angle_min, ...) and "
     "publishes scan, or urg_node/echoes.\n",
     ReconfigureNames::entries, urg_node_setup},
    // In ira_laser_tools the names of the node and of its executable differ.
    {"laserscan_multi_merger", "laser_multi_merger",
     "Stands in for laserscan_multi_merger of ira_laser_tools: reads its private parameters "
     "(laserscan_topics, destination_frame, ...) and publishes the merged scan and cloud.\n",
     ReconfigureNames::node, laser_merger_setup},
    {virtualizer_name, virtualizer_name,
     "Stands in for laserscan_virtualizer of ira_laser_tools: reads its parameters (cloud_topic, "
     "virtual_laser_scan, ...) and publishes a scan for each virtual frame.\n",
     ReconfigureNames::node, laser_virtualizer_setup}};

std::string usage_of(const Dropin& dropin) {
  return std::string(dropin.usage) + "usage: " + std::string(dropin.executable) +
         " [_PARAMETER:=VALUE]... [FROM:=TO]...\n";
}

bool asks_for_help(const std::string& argument) { return argument == "--help" || argument == "-h"; }
bool is_assignment(const std::string& argument) { return argument.find(":=") != std::string::npos; }

/// Handles --help and rejects arguments that are neither parameters nor remappings; returns the exit code
/// then.
std::optional<int> answer(const Dropin& dropin, const Arguments& arguments, std::ostream& out,
                          std::ostream& err) {
  if (std::any_of(arguments.begin(), arguments.end(), asks_for_help)) {
    out << usage_of(dropin);
    return exit_ok;
  }
  const auto unknown = std::find_if_not(arguments.begin(), arguments.end(), is_assignment);
  if (unknown == arguments.end()) return std::nullopt;
  err << "'" << *unknown << "' is neither a parameter nor a remapping\n" << usage_of(dropin);
  return exit_usage;
}

int run_setup(const Dropin& dropin, const Arguments& arguments, std::ostream& out, std::ostream& err) {
  const std::string node = full_node_name(arguments, dropin.node);
  NodeParameters parameters = wait_for_parameters(arguments, node);
  if (dropin.executable == virtualizer_name)
    parameters =
        with_absolute_names(parameters, wait_for_parameters(arguments, std::string("/") + virtualizer_name));
  DropinSetup setup = dropin.setup(parameters);
  for (const auto& warning : setup.warnings) log_warn("{}", warning);
  for (const auto& remark : setup.remarks) log_info("{}", remark);
  const std::string yaml = setup.keys.yaml();
  log_info("the same as a configuration for `lidard run`:\n{}", yaml);
  const Config config = parse_config(yaml, "parameters of " + node);
  // Several drop-ins run beside each other.
  std::string name = node.substr(1);
  std::replace(name.begin(), name.end(), '/', '-');
  ::setenv("LIDARD_SOCKET", (runtime_folder() + "/" + name + ".control").c_str(), 0);
  setup.replay.ros = {dropin.node, arguments, dropin.reconfigure};
  if (setup.replay.captures.empty()) return run_daemon(config, setup.replay.ros, err);
  return run_replay(setup.replay, config, out, err);
}

}  // namespace

std::optional<int> run_dropin(const std::string& executable, const Arguments& arguments, std::ostream& out,
                              std::ostream& err) {
  const auto* const dropin = std::find_if(std::begin(dropins), std::end(dropins),
                                          [&](const Dropin& one) { return one.executable == executable; });
  if (dropin == std::end(dropins)) return std::nullopt;
  if (const auto code = answer(*dropin, arguments, out, err)) return code;
  try {
    return run_setup(*dropin, arguments, out, err);
  } catch (const ConfigError& e) {
    err << e.what() << '\n';
    return exit_config;
  } catch (const RosError& e) {
    err << e.what() << '\n';
    return exit_usage;
  }
}

}  // namespace lidard
