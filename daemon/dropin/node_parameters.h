// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

namespace lidard {

/// Values of a node's private parameters as text, by name; those of a list are separated by blanks.
using NodeParameters = std::map<std::string, std::string>;

/// The node's name with its namespace: `name` or __name:=…, in __ns:=… or $ROS_NAMESPACE.
std::string full_node_name(const std::vector<std::string>& arguments, const std::string& name);

/// The private parameters of `node`: those of the master, for which it waits, and _name:=value of the
/// arguments, which win.
NodeParameters wait_for_parameters(const std::vector<std::string>& arguments, const std::string& node);

}  // namespace lidard
