// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/pose_edit.h"

#include <algorithm>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/config/values.h"
#include "daemon/config/yaml.h"

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

/// Where a place is in the text of its file.
std::size_t offset_of(const std::string& text, const Place& place) {
  std::size_t line = 0;
  for (int i = 1; i < place.line; ++i) line = text.find('\n', line) + 1;
  return line + static_cast<std::size_t>(place.column - 1);
}

/// What separates two keys of the mapping at `value`, in braces or on lines of their own that begin below
/// `key`.
std::string separator(const std::string& text, const Place& value, const Place& key) {
  if (text.at(offset_of(text, value)) == '{') return ", ";
  return "\n" + std::string(static_cast<std::size_t>(key.column - 1), ' ');
}

/// `values` in place of the list `old`, which must stand in brackets.
Edit list_edit(const std::string& text, const Value& old, const std::string& sensor,
               const std::string& values) {
  const std::size_t from = offset_of(text, old.place());
  const std::size_t end = text.find(']', from);
  if (text.at(from) != '[' || end == std::string::npos)
    throw std::runtime_error("line " + std::to_string(old.place().line) + ": write the pose of " + sensor +
                             " as {xyz: [x, y, z], rpy_deg: [roll, pitch, yaw]}, so that it can be replaced");
  return {from, end + 1, values};
}

/// The numbers of a pose in place of the old ones; the angles in the unit of the old ones.
void add_pose_edits(const std::string& text, const Mapping& old, const std::string& sensor, const Pose& pose,
                    std::vector<Edit>& edits) {
  const std::string degrees = list_of(rpy_of(pose) * deg_per_rad, 3);
  edits.push_back(list_edit(text, old.where("xyz"), sensor, list_of(pose.translation(), 4)));
  if (const auto rpy = old.find("rpy"))
    edits.push_back(list_edit(text, *rpy, sensor, list_of(rpy_of(pose), 6)));
  else if (const auto rpy_deg = old.find("rpy_deg"))
    edits.push_back(list_edit(text, *rpy_deg, sensor, degrees));
  else
    edits.back().text +=
        separator(text, old.self().place(), old.where("xyz").key_place()) + "rpy_deg: " + degrees;
}

/// The offset in place of the old one, or as a key before `pose`.
Edit time_offset_edit(const std::string& text, const Mapping& sensor, double offset) {
  const std::string number = rounded(offset, 5);
  if (const auto old = sensor.find("time_offset")) {
    const std::size_t from = offset_of(text, old->place());
    return {from, from + old->text().size(), number};
  }
  const Place& pose = sensor.where("pose").key_place();
  const std::size_t from = offset_of(text, pose);
  return {from, from, "time_offset: " + number + separator(text, sensor.self().place(), pose)};
}

}  // namespace

std::string with_mounts(const std::string& file, const std::map<std::string, MountEdit>& mounts) {
  // The places that the parser reports leave out a byte order mark.
  const std::size_t mark = file.compare(0, 3, "\xEF\xBB\xBF") == 0 ? 3 : 0;
  const std::string text = file.substr(mark);
  const Value sensors = value_at(parse_yaml(text, {}), "sensors");
  std::vector<Edit> edits;
  for (const auto& [name, mount] : mounts) {
    const Mapping sensor(value_at(sensors, name));
    // What is merged with << stands elsewhere, before its entry.
    const Place& begin = sensor.self().place();
    const Place& pose = sensor.where("pose").key_place();
    if (!sensor.has("pose") || std::tie(pose.line, pose.column) < std::tie(begin.line, begin.column))
      throw std::runtime_error("write the pose of " + name +
                               " into its own entry, not into one that is merged with <<");
    if (mount.time_offset) edits.push_back(time_offset_edit(text, sensor, *mount.time_offset));
    add_pose_edits(text, sensor.inside("pose"), name, mount.pose, edits);
  }
  std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.from > b.from; });
  std::string result = text;
  for (const Edit& edit : edits) result.replace(edit.from, edit.to - edit.from, edit.text);
  return file.substr(0, mark) + result;
}

}  // namespace lidard
