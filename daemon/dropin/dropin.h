// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "daemon/dropin/moving.h"

namespace lidard {

/// The node's name with its namespace: `name` or __name:=…, in __ns:=… or $ROS_NAMESPACE.
std::string full_node_name(const std::vector<std::string>& arguments, const std::string& name);

/// The private parameters of `node`: those of the master (the function waits for it), overridden by
/// _name:=value of the arguments.
NodeParameters wait_for_parameters(const std::vector<std::string>& arguments, const std::string& node);

/// Runs as the node of another package named by `executable` (argv[0] without folder): reads the node's
/// private parameters from the master, for which it waits, and publishes the node's topics. Returns the exit
/// code; empty: `executable` is `lidard` itself.
std::optional<int> run_dropin(const std::string& executable, const std::vector<std::string>& arguments,
                              std::ostream& out, std::ostream& err);

}  // namespace lidard
