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

/// Without an exponent: 1e-05 is a text in YAML 1.1.
std::string rounded(double value, int digits) {
  std::string number = printed("%.*f", digits, value);
  number.erase(number.find_last_not_of('0') + 1);
  if (number.back() == '.') number.pop_back();
  return number == "-0" ? "0" : number;
}

std::string list_of(const Eigen::Vector3d& values, int digits) {
  return "[" + rounded(values.x(), digits) + ", " + rounded(values.y(), digits) + ", " +
         rounded(values.z(), digits) + "]";
}

/// What separates two keys of a mapping, in braces or on lines of their own that begin below `at`.
std::string separator(bool flow, const YAML::Mark& at) {
  return flow ? std::string(", ") : "\n" + std::string(static_cast<std::size_t>(at.column), ' ');
}

/// `values` in place of the list that begins at `old`, which must stand in brackets.
Edit list_edit(const std::string& text, const YAML::Node& old, const std::string& sensor,
               const std::string& values) {
  const auto from = static_cast<std::size_t>(old.Mark().pos);
  const std::size_t end = text.find(']', from);
  if (from >= text.size() || text[from] != '[' || end == std::string::npos)
    throw std::runtime_error("line " + std::to_string(old.Mark().line + 1) + ": write the pose of " + sensor +
                             " as {xyz: [x, y, z], rpy_deg: [roll, pitch, yaw]}, so that it can be replaced");
  return {from, end + 1, values};
}

/// The numbers of a pose in place of the old ones; the angles in the unit of the old ones.
void add_pose_edits(const std::string& text, const YAML::Node& old, const std::string& sensor,
                    const Pose& pose, std::vector<Edit>& edits) {
  const YAML::Node rpy = old["rpy"], rpy_deg = old["rpy_deg"];
  const std::string degrees = list_of(rpy_of(pose) * deg_per_rad, 3);
  edits.push_back(list_edit(text, old["xyz"], sensor, list_of(pose.translation(), 4)));
  const bool flow = text[static_cast<std::size_t>(old.Mark().pos)] == '{';
  if (rpy)
    edits.push_back(list_edit(text, rpy, sensor, list_of(rpy_of(pose), 6)));
  else if (rpy_deg)
    edits.push_back(list_edit(text, rpy_deg, sensor, degrees));
  else
    edits.back().text += separator(flow, old.Mark()) + "rpy_deg: " + degrees;
}

/// The offset in place of the old one, or as a key before `pose`.
Edit time_offset_edit(const std::string& text, const YAML::Node& sensor, double offset) {
  const std::string number = rounded(offset, 5);
  if (const YAML::Node old = sensor["time_offset"]) {
    const auto from = static_cast<std::size_t>(old.Mark().pos);
    return {from, from + old.Scalar().size(), number};
  }
  for (const auto& entry : sensor) {
    if (entry.first.Scalar() != "pose") continue;
    const YAML::Mark at = entry.first.Mark();
    const auto from = static_cast<std::size_t>(at.pos);
    const bool flow = text[static_cast<std::size_t>(sensor.Mark().pos)] == '{';
    return {from, from, "time_offset: " + number + separator(flow, at)};
  }
  throw std::runtime_error("line " + std::to_string(sensor.Mark().line + 1) +
                           ": there is no pose beside which time_offset could be written");
}

}  // namespace

std::string with_mounts(const std::string& file, const std::map<std::string, MountEdit>& mounts) {
  // The positions that yaml-cpp reports leave out a byte order mark.
  const std::size_t mark = file.compare(0, 3, "\xEF\xBB\xBF") == 0 ? 3 : 0;
  const std::string text = file.substr(mark);
  const YAML::Node sensors = YAML::Load(text)["sensors"];
  std::vector<Edit> edits;
  for (const auto& [name, mount] : mounts) {
    if (!sensors[name].IsMap() || !sensors[name]["pose"])
      throw std::runtime_error("write the pose of " + name +
                               " into its own entry, not into one that is merged with <<");
    if (mount.time_offset) edits.push_back(time_offset_edit(text, sensors[name], *mount.time_offset));
    add_pose_edits(text, sensors[name]["pose"], name, mount.pose, edits);
  }
  std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.from > b.from; });
  std::string result = text;
  for (const Edit& edit : edits) result.replace(edit.from, edit.to - edit.from, edit.text);
  return file.substr(0, mark) + result;
}

}  // namespace lidard
