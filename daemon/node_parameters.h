// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "daemon/velodyne_node.h"

namespace lidard {

/// The name of the node unless __name:= says otherwise.
constexpr const char* velodyne_node_name = "velodyne_node";

/// The node's name with its namespace: `name` or __name:=…, in __ns:=… or $ROS_NAMESPACE.
std::string full_node_name(const std::vector<std::string>& arguments, const std::string& name);

/// The private parameters of `node`: those of the master, for which it waits, and _name:=value of the
/// arguments, which win.
NodeParameters wait_for_parameters(const std::vector<std::string>& arguments, const std::string& node);

}  // namespace lidard
