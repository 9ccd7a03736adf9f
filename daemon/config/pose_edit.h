// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include "core/base/pose.h"

namespace lidard {

/// The text of a configuration with other poses of sensors; all else, comments included, stays as it is.
/// Throws std::runtime_error with the line where a pose is written in a way that cannot be replaced.
std::string with_poses(const std::string& text, const std::map<std::string, Pose>& poses);

}  // namespace lidard
