// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace lidard {

/// What `lidard snapshot` was asked for.
struct SnapshotOptions {
  std::string config;
  std::vector<std::string> captures;
  std::optional<double> at;     ///< s into the capture; unset: its middle
  std::optional<double> range;  ///< m from base_frame to the picture's edge; unset: fits what was measured
  std::string areas;            ///< topic whose free and unobserved areas are shaded; empty: see make_view()
  std::string motion;           ///< a bag whose tf or odometry tells how the vehicle moved; empty: it stood
  std::string output;           ///< .png or .svg
};

/// Plays captures through the pipeline of a configuration up to one moment and draws what is known then, from
/// above. Returns the exit code.
int run_snapshot(const SnapshotOptions& options, std::ostream& err);

}  // namespace lidard
