// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/pose.h"
#include "drivers/document.h"

namespace lidard {

/// The replacement of a key of former versions, by its path like merged_scans.m.fuse; empty: there was no
/// such key.
std::string_view instead_of(const std::string& path);
/// The key that stands for one of other drivers, like sensors.a.hostname; empty: not known.
std::string_view ours_for(const std::string& path);

/// A mapping with known keys. Unknown and repeated ones are left out, and are mistakes.
Mapping known_mapping(const Value& value, const std::vector<std::string_view>& known, Mistakes& mistakes);
/// Reads each entry of a mapping, whose names are `known` ones unless that is empty; throws all mistakes.
void read_each(const Value& mapping, const std::vector<std::string_view>& known,
               const std::function<void(const std::string& name, const Value& value)>& read);
/// A pose from {xyz: m, rpy: rad or rpy_deg}.
Pose read_pose(const Value& value);
/// A frame's name without leading slash (tf2 has none).
std::string read_frame(const Value& value);
/// A ROS topic name.
std::string read_topic(const Value& value);
/// Throws at the key if `name` cannot be part of a topic name.
void check_entry_name(const std::string& name, const Value& value);
/// A topic or frame as it is compared with others.
std::string without_slash(const std::string& name);
/// Roll, pitch, yaw (fixed axes, rad) that make_pose() turns into the rotation of `pose`.
Eigen::Vector3d rpy_of(const Pose& pose);

}  // namespace lidard
