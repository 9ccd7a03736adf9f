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

/// A mount as keys of a sensor in braces.
std::string mount_text(const MountEdit& mount);

/// The text of a configuration with other mounts of sensors by their names; all else, comments included,
/// stays as it is. Throws ConfigError with the location in `file`, and what to write there, where one cannot
/// be replaced by itself. Other entries may have anchors of what is replaced: compare what the text says
/// then.
std::string with_mounts(const std::string& text, const std::string& file,
                        const std::map<std::string, MountEdit>& mounts);

}  // namespace lidard
