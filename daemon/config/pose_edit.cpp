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

std::string list_of(const Eigen::Vector3d& values, const char* format) {
  std::string text = "[";
  for (int i = 0; i < 3; ++i) {
    std::string number = printed(format, values[i]);
    number.erase(number.find_last_not_of('0') + 1);
    if (number.back() == '.') number.pop_back();
    text += (i == 0 ? "" : ", ") + (number == "-0" ? "0" : number);
  }
  return text + "]";
}

}  // namespace

std::string with_poses(const std::string& text, const std::map<std::string, Pose>& poses) {
  const YAML::Node sensors = YAML::Load(text)["sensors"];
  std::vector<Edit> edits;
  for (const auto& [name, pose] : poses) {
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
