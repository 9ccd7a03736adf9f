// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/values.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "core/base/angle.h"
#include "core/base/nearest.h"

namespace lidard {
namespace {

constexpr double vehicle_size_m = 1000;  // a vehicle is smaller; millimetres written for metres are not

bool is_word_character(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// The rules of ROS names: `/` or a letter first; then letters, digits, `_`, single `/`. Private names (`~x`)
/// are no topics to roscpp's NodeHandle.
bool is_topic_name(const std::string& name) {
  const std::size_t first = name.find_first_not_of('/');
  if (first > 1 || name.find("//") != std::string::npos) return false;  // npos is greater, too
  if (std::isalpha(static_cast<unsigned char>(name[first])) == 0 || name.back() == '/') return false;
  return std::all_of(name.begin() + static_cast<std::ptrdiff_t>(first), name.end(),
                     [](char c) { return is_word_character(c) || c == '/'; });
}

std::string comma_list(const std::vector<std::string_view>& words) {
  std::string list;
  for (auto word = words.begin(); word != words.end(); ++word) {
    if (std::find(words.begin(), word, *word) == word) list.append(list.empty() ? "" : ", ").append(*word);
  }
  return list.find(',') == std::string::npos ? list : "one of " + list;
}

[[noreturn]] void fail_unknown(const std::string& key, const Value& entry,
                               const std::vector<std::string_view>& known_keys) {
  if (const std::string_view instead = instead_of(entry.path()); !instead.empty())
    entry.fail_at_key("is a key of former versions", std::string(instead));
  std::string_view near = ours_for(entry.path());
  if (near.empty()) near = nearest_word(key, known_keys);
  throw ConfigError(entry.key_location(), "unknown key " + entry.path() + "; expected " +
                                              (near.empty() ? comma_list(known_keys) : std::string(near)));
}

}  // namespace

Mapping known_mapping(const Value& value, const std::vector<std::string_view>& known, Mistakes& mistakes) {
  Mapping::Entries entries;
  for (auto& one : value.entries(&mistakes)) {
    if (std::find(known.begin(), known.end(), one.first) != known.end())
      entries.push_back(std::move(one));
    else
      mistakes.attempt([&] { fail_unknown(one.first, one.second, known); });
  }
  return {value, std::move(entries), !mistakes.any()};
}

void read_each(const Value& mapping, const std::vector<std::string_view>& known,
               const std::function<void(const std::string& name, const Value& value)>& read) {
  Mistakes mistakes;
  const auto entries =
      known.empty() ? mapping.entries(&mistakes) : known_mapping(mapping, known, mistakes).entries();
  for (const auto& entry : entries) mistakes.attempt([&] { read(entry.first, entry.second); });
  mistakes.throw_if_any();
}

std::string without_slash(const std::string& name) {
  return name.substr(name.compare(0, 1, "/") == 0 ? 1 : 0);
}

Pose read_pose(const Value& value) {
  Mistakes mistakes;
  const Mapping pose = known_mapping(value, {"xyz", "rpy", "rpy_deg"}, mistakes);
  mistakes.throw_if_any();
  const std::string expected = "{xyz: [x, y, z], rpy_deg: [roll, pitch, yaw]}";
  const std::vector<double> xyz = pose.require("xyz", expected).numbers(3, vehicle_size_m, "m");
  Eigen::Vector3d rpy = Eigen::Vector3d::Zero();
  pose.in_rad("rpy", [&](const Value& angles, double to_rad) {
    const bool rad = to_rad == 1;
    const auto list =
        angles.numbers(3, rad ? most_turn_rad : 400, rad ? "rad (degrees: rpy_deg)" : "degrees");
    rpy = Eigen::Vector3d(list[0], list[1], list[2]) * to_rad;
  });
  Pose made = make_pose({xyz[0], xyz[1], xyz[2]}, rpy);
  if (!is_rigid(made)) value.fail("is not rigid", expected);
  return made;
}

Eigen::Vector3d rpy_of(const Pose& pose) {
  const Eigen::Matrix3d& r = pose.linear();
  const double level = std::hypot(r(0, 0), r(1, 0));
  const double pitch = std::atan2(-r(2, 0), level);
  // Looking straight up or down, roll and yaw turn about one axis: all of it counts as yaw.
  if (level < 1e-7) return {0, pitch, std::atan2(-r(0, 1), r(1, 1))};
  return {std::atan2(r(2, 1), r(2, 2)), pitch, std::atan2(r(1, 0), r(0, 0))};
}

std::string read_frame(const Value& value) {
  const std::string expected = "the name of a tf frame, without blanks";
  std::string name = without_slash(value.text(expected));
  const bool blank =
      std::any_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) <= ' '; });
  if (name.empty() || name.front() == '/' || blank) value.fail("is " + value.quoted(), expected);
  return name;
}

std::string read_topic(const Value& value) {
  const std::string expected = "a topic name: letters, digits, _ and /";
  std::string name = value.text(expected);
  if (!is_topic_name(name)) value.fail("is " + value.quoted(), expected);
  return name;
}

void check_entry_name(const std::string& name, const Value& value) {
  const bool good = std::isalpha(static_cast<unsigned char>(name.front())) != 0 &&
                    std::all_of(name.begin(), name.end(), is_word_character);
  if (!good)
    value.fail_at_key("cannot be part of a topic name", "a letter, then letters, digits and underscores");
}

}  // namespace lidard
