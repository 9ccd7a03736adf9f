// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace lidard {

/// The command line of `lidard`. ROS remappings (name:=value) may stand anywhere.
int run_cli(int argc, char** argv);

}  // namespace lidard
