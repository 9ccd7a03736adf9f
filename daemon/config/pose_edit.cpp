// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/pose_edit.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/config/reading.h"

namespace lidard {
namespace {

struct Edit {
  std::size_t from, to;  // characters of the text
  std::string text;
};

/// The list that begins at a node, including the brackets.
Edit list_at(const std::string& text, const YAML::Node& node, const std::string& sensor) {
  const auto from = static_cast<std::size_t>(node.Mark().pos);
  const std::size_t end = text.find(']', from);
  if (from >= text.size() || text[from] != '[' || end == std::string::npos)
    throw std::runtime_error("line " + std::to_string(node.Mark().line + 1) + ": write the pose of " +
                             sensor +
                             " as {xyz: [x, y, z], rpy_deg: [roll, pitch, yaw]}, so that it can be replaced");
  return {from, end + 1, {}};
}

std::string short_number(double value, const char* format) {
  std::string number = printed(format, value);
  number.erase(number.find_last_not_of('0') + 1);
  if (number.back() == '.') number.pop_back();
  return number == "-0" ? "0" : number;
}

std::string list_of(const Eigen::Vector3d& values, const char* format) {
  return "[" + short_number(values.x(), format) + ", " + short_number(values.y(), format) + ", " +
         short_number(values.z(), format) + "]";
}

/// The offset in place of the old one, or as a key before `pose`.
Edit time_offset_edit(const std::string& text, const YAML::Node& sensor, double offset) {
  const std::string number = short_number(offset, "%.5f");
  if (const YAML::Node old = sensor["time_offset"]) {
    const auto from = static_cast<std::size_t>(old.Mark().pos);
    return {from, from + old.Scalar().size(), number};
  }
  for (const auto& entry : sensor) {
    if (entry.first.Scalar() != "pose") continue;
    const YAML::Mark at = entry.first.Mark();
    const auto from = static_cast<std::size_t>(at.pos);
    const bool flow = text[static_cast<std::size_t>(sensor.Mark().pos)] == '{';
    const std::string next =
        flow ? std::string(", ") : "\n" + std::string(static_cast<std::size_t>(at.column), ' ');
    return {from, from, "time_offset: " + number + next};
  }
  throw std::runtime_error("line " + std::to_string(sensor.Mark().line + 1) +
                           ": there is no pose beside which time_offset could be written");
}

}  // namespace

std::string with_mounts(const std::string& text, const std::map<std::string, MountEdit>& mounts) {
  const YAML::Node sensors = YAML::Load(text)["sensors"];
  std::vector<Edit> edits;
  for (const auto& [name, mount] : mounts) {
    const Pose& pose = mount.pose;
    if (mount.time_offset) edits.push_back(time_offset_edit(text, sensors[name], *mount.time_offset));
    const YAML::Node old = sensors[name]["pose"];
    const YAML::Node xyz = old["xyz"], rpy = old["rpy"], rpy_deg = old["rpy_deg"];
    const Eigen::Vector3d angles = rpy_of(pose);
    if (!xyz) throw std::runtime_error("the pose of " + name + " has no xyz");
    edits.push_back(list_at(text, xyz, name));
    edits.back().text = list_of(pose.translation(), "%.4f");
    if (rpy) {
      edits.push_back(list_at(text, rpy, name));
      edits.back().text = list_of(angles, "%.6f");
      continue;
    }
    const std::string degrees = list_of(angles * deg_per_rad, "%.3f");
    if (!rpy_deg) {
      const bool flow = text[static_cast<std::size_t>(old.Mark().pos)] == '{';
      edits.back().text +=
          (flow ? ", " : "\n" + std::string(static_cast<std::size_t>(old.Mark().column), ' ')) +
          "rpy_deg: " + degrees;
      continue;
    }
    edits.push_back(list_at(text, rpy_deg, name));
    edits.back().text = degrees;
  }
  std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.from > b.from; });
  std::string result = text;
  for (const Edit& edit : edits) result.replace(edit.from, edit.to - edit.from, edit.text);
  return result;
}

}  // namespace lidard
