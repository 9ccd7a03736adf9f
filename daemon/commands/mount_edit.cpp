// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/mount_edit.h"

#include <algorithm>
#include <vector>

#include "core/base/angle.h"
#include "core/base/number_text.h"
#include "daemon/config/values.h"
#include "daemon/yaml/yaml.h"

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
  MountEditor(const std::string& text, const std::string& sensor, const MountEdit& mount,
              std::vector<Edit>& edits)
      : text_(text), sensor_(sensor), mount_(mount), edits_(edits) {}

  void edit(const Value& sensors) {
    const auto found = find(sensors, sensor_);
    if (!found) fail(sensors.location());
    const Value& entry = *found;
    const auto pose = find(entry, "pose");
    const auto xyz = pose ? find(*pose, "xyz") : pose;
    if (!xyz) fail(entry.location());
    if (mount_.time_offset) edit_time_offset(entry, *pose);
    replace(*xyz, mount_.pose.translation(), 4);
    const Eigen::Vector3d angles = rpy_of(mount_.pose), degrees = angles * deg_per_rad;
    if (const auto rpy = find(*pose, "rpy"))
      replace(*rpy, angles, 6);
    else if (const auto rpy_deg = find(*pose, "rpy_deg"))
      replace(*rpy_deg, degrees, 3);
    else
      insert_after(*xyz, *pose, "rpy_deg: " + list_of(degrees, 3));
  }

 private:
  [[noreturn]] void fail(const Location& at) const {
    throw ConfigError(
        at, "the mount of " + sensor_ +
                " is merged in, has an anchor or is an alias, so that it cannot be replaced; expected " +
                mount_text(mount_) + " in the entry of " + sensor_);
  }
  std::size_t index_of(const Location& at) const {
    std::size_t line_begin = 0;
    for (int line = 1; line < at.line; ++line) line_begin = text_.find('\n', line_begin) + 1;
    return line_begin + static_cast<std::size_t>(at.column) - 1;
  }
  std::size_t begin_of(const Value& value) const { return index_of(value.location()); }
  bool is_flow(const Value& value) const {
    return text_[begin_of(value)] == '{' || text_[begin_of(value)] == '[';
  }

  /// The value of a key of the mapping itself. What is merged in stands before the mapping, and an alias
  /// stands where its anchor is, which is before the key.
  std::optional<Value> find(const Value& map, const std::string& key) const {
    auto value = Mapping(map).find(key);
    if (!value || index_of(value->key_location()) < begin_of(map)) return std::nullopt;
    if (begin_of(*value) < index_of(value->key_location())) fail(value->key_location());
    return value;
  }
  void replace(const Value& number, const std::string& by) {
    const std::string old = number.text();
    if (text_.compare(begin_of(number), old.size(), old) != 0) fail(number.location());
    edits_.push_back({begin_of(number), begin_of(number) + old.size(), by});
  }
  void replace(const Value& list, const Eigen::Vector3d& values, int digits) {
    Eigen::Index i = 0;
    for (const Value& number : list.items("a list of 3 numbers")) {
      if (begin_of(number) < begin_of(list)) fail(list.location());
      replace(number, rounded(values[i++], digits));
    }
  }
  /// What begins a line below the first key of a mapping.
  std::string new_line(const Value& map) const {
    return (text_.find("\r\n") == std::string::npos ? "\n" : "\r\n") +
           std::string(static_cast<std::size_t>(map.location().column) - 1, ' ');
  }
  /// A further key after a list that `map` has.
  void insert_after(const Value& list, const Value& map, const std::string& entry) {
    const Value last = list.items("a list of 3 numbers").back();
    std::size_t at = begin_of(last) + last.text().size();
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
  void edit_time_offset(const Value& sensor, const Value& pose) {
    const std::string number = rounded(*mount_.time_offset, 5);
    if (const auto old = find(sensor, "time_offset")) return replace(*old, number);
    const std::size_t at = index_of(pose.key_location());
    edits_.push_back({at, at, "time_offset: " + number + (is_flow(sensor) ? ", " : new_line(sensor))});
  }

  const std::string &text_, &sensor_;
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
  // The columns that yaml-cpp reports leave out a byte order mark.
  const std::size_t mark = text.compare(0, 3, "\xEF\xBB\xBF") == 0 ? 3 : 0;
  std::string result = text.substr(mark);
  const Value sensors = *Mapping(parse_yaml(result, file)).find("sensors");
  std::vector<Edit> edits;
  for (const auto& [name, mount] : mounts) MountEditor(result, name, mount, edits).edit(sensors);
  std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.from > b.from; });
  for (const Edit& edit : edits) result.replace(edit.from, edit.to - edit.from, edit.text);
  return text.substr(0, mark) + result;
}

}  // namespace lidard
