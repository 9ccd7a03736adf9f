// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

namespace lidard {

/// Where a program of ours that stands in for another package's node runs and what it was started with.
struct DropinCall {
  std::vector<std::string> arguments;  ///< remappings and parameters as roslaunch passes them
  std::string node;                    ///< full name
  std::ostream& out;
  std::ostream& err;
};

/// Runs such a program: answers --help, refuses arguments that mean nothing to ROS, and turns what `body`
/// throws into messages and exit codes. `name` is the node's unless __name:= says otherwise.
int run_dropin(const char* name, const char* usage, const std::vector<std::string>& arguments,
               std::ostream& out, std::ostream& err, const std::function<int(const DropinCall&)>& body);

/// The program that `executable` (argv[0] without folder) stands for; empty: it is `lidard` itself.
std::function<int(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err)>
find_dropin(const std::string& executable);

}  // namespace lidard
