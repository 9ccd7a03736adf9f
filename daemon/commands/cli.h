// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidard {

/// Exit codes of every command (sysexits.h for the last).
constexpr int exit_ok = 0;
constexpr int exit_failed = 1;
constexpr int exit_usage = 2;
constexpr int exit_config = 78;

/// The command line of `lidard`. ROS remappings (name:=value) may stand anywhere.
int run_cli(int argc, char** argv);

}  // namespace lidard
