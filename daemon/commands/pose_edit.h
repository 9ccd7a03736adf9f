// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <optional>
#include <string>

#include "core/base/pose.h"

namespace lidard {

/// What a calibration changes of a sensor.
struct MountEdit {
  Pose pose;
  std::optional<double> time_offset;  ///< s; unset: stays
};

/// The text of a configuration with other mounts of sensors by their names; all else, comments included,
/// stays as it is. Throws std::runtime_error with the line where one is written in a way that cannot be
/// replaced.
std::string with_mounts(const std::string& text, const std::map<std::string, MountEdit>& mounts);

}  // namespace lidard
