// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/pose_edit.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <vector>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/config/values.h"
#include "drivers/config_error.h"

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

/// The edits of one sensor. Numbers are replaced where they stand, so that comments between them stay, too.
class MountEditor {
 public:
  MountEditor(const std::string& text, const std::string& file, const std::string& sensor,
              const MountEdit& mount, std::vector<Edit>& edits)
      : text_(text), file_(file), sensor_(sensor), mount_(mount), edits_(edits) {}

  void edit(const YAML::Node& sensors) {
    const YAML::Node entry = value_of(sensors, sensor_), pose = value_of(entry, "pose");
    if (!pose.IsDefined()) fail(entry.Mark());
    if (mount_.time_offset) edit_time_offset(entry);
    const YAML::Node xyz = value_of(pose, "xyz"), rpy = value_of(pose, "rpy"),
                     rpy_deg = value_of(pose, "rpy_deg");
    replace(xyz, mount_.pose.translation(), 4);
    const Eigen::Vector3d angles = rpy_of(mount_.pose), degrees = angles * deg_per_rad;
    if (rpy.IsDefined())
      replace(rpy, angles, 6);
    else if (rpy_deg.IsDefined())
      replace(rpy_deg, degrees, 3);
    else
      insert_after(xyz, pose, "rpy_deg: " + list_of(degrees, 3));
  }

 private:
  [[noreturn]] void fail(const YAML::Mark& at) const {
    throw ConfigError(
        {file_, at.line + 1, at.column + 1},
        "the mount of " + sensor_ +
            " is merged in, has an anchor or is an alias, so that it cannot be replaced; expected " +
            mount_text(mount_) + " in the entry of " + sensor_);
  }
  static std::size_t begin_of(const YAML::Node& node) { return static_cast<std::size_t>(node.Mark().pos); }
  bool is_flow(const YAML::Node& node) const {
    return text_[begin_of(node)] == '{' || text_[begin_of(node)] == '[';
  }

  /// The value of a key; undefined: there is none. An alias stands where its anchor is, which is before the
  /// key.
  YAML::Node value_of(const YAML::Node& map, const std::string& key) const {
    for (const auto& entry : map) {
      if (entry.first.Scalar() != key) continue;
      if (begin_of(entry.second) < begin_of(entry.first)) fail(entry.first.Mark());
      return entry.second;
    }
    return YAML::Node(YAML::NodeType::Undefined);
  }
  void replace(const YAML::Node& number, const std::string& by) {
    const std::string& old = number.Scalar();
    if (text_.compare(begin_of(number), old.size(), old) != 0) fail(number.Mark());
    edits_.push_back({begin_of(number), begin_of(number) + old.size(), by});
  }
  void replace(const YAML::Node& list, const Eigen::Vector3d& values, int digits) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (begin_of(list[i]) < begin_of(list)) fail(list.Mark());
      replace(list[i], rounded(values[static_cast<Eigen::Index>(i)], digits));
    }
  }
  /// What begins a line below the first key of a mapping.
  std::string new_line(const YAML::Node& map) const {
    return (text_.find("\r\n") == std::string::npos ? "\n" : "\r\n") +
           std::string(static_cast<std::size_t>(map.Mark().column), ' ');
  }
  /// A further key after a list that `map` has.
  void insert_after(const YAML::Node& list, const YAML::Node& map, const std::string& entry) {
    std::size_t at = begin_of(list[2]) + list[2].Scalar().size();
    if (is_flow(list)) {
      for (; text_[at] != ']'; ++at) {
        if (text_[at] == '#') at = text_.find('\n', at);
      }
      ++at;
    }
    if (is_flow(map)) return edits_.push_back({at, at, ", " + entry});
    at = std::min(text_.find_first_of("\r\n", at), text_.size());
    edits_.push_back({at, at, new_line(map) + entry});
  }
  /// The offset in place of the old one, or as a key before `pose`.
  void edit_time_offset(const YAML::Node& sensor) {
    const std::string number = rounded(*mount_.time_offset, 5);
    const YAML::Node old = value_of(sensor, "time_offset");
    if (old.IsDefined()) return replace(old, number);
    for (const auto& entry : sensor) {
      if (entry.first.Scalar() != "pose") continue;
      const std::size_t at = begin_of(entry.first);
      edits_.push_back({at, at, "time_offset: " + number + (is_flow(sensor) ? ", " : new_line(sensor))});
    }
  }

  const std::string &text_, &file_, &sensor_;
  const MountEdit& mount_;
  std::vector<Edit>& edits_;
};

}  // namespace

std::string mount_text(const MountEdit& mount) {
  return (mount.time_offset ? "time_offset: " + rounded(*mount.time_offset, 5) + ", " : "") +
         "pose: {xyz: " + list_of(mount.pose.translation(), 4) +
         ", rpy_deg: " + list_of(rpy_of(mount.pose) * deg_per_rad, 3) + "}";
}

std::string with_mounts(const std::string& text, const std::string& file,
                        const std::map<std::string, MountEdit>& mounts) {
  // The positions that yaml-cpp reports leave out a byte order mark.
  const std::size_t mark = text.compare(0, 3, "\xEF\xBB\xBF") == 0 ? 3 : 0;
  std::string result = text.substr(mark);
  const YAML::Node sensors = YAML::Load(result)["sensors"];
  std::vector<Edit> edits;
  for (const auto& [name, mount] : mounts) MountEditor(result, file, name, mount, edits).edit(sensors);
  std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.from > b.from; });
  for (const Edit& edit : edits) result.replace(edit.from, edit.to - edit.from, edit.text);
  return text.substr(0, mark) + result;
}

}  // namespace lidard
