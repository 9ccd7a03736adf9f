// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/dropin/launch_file.h"

#include <array>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "daemon/config/config.h"

namespace lidard {
namespace {

// The interpreter that ROS is installed for; another one on PATH often lacks it.
constexpr const char* python = "/usr/bin/python3";

/// The script is beside the program in a build tree and in lib/lidard after installation.
std::filesystem::path script() {
  const auto beside = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  for (const auto& folder : {beside, beside / "../lib/lidard"}) {
    if (std::filesystem::exists(folder / "read_launch.py")) return folder / "read_launch.py";
  }
  throw std::runtime_error("read_launch.py is neither beside lidard nor in ../lib/lidard; reinstall lidard");
}

/// A word for the shell.
std::string quoted(std::string word) {
  for (std::size_t at = word.find('\''); at != std::string::npos; at = word.find('\'', at + 4))
    word.replace(at, 1, "'\\''");
  return "'" + word + "'";
}

/// The program's output, and true if it succeeded.
std::pair<std::string, bool> output_of(const std::vector<std::string>& words) {
  std::string command = "exec";
  for (const std::string& word : words) command += " " + quoted(word);
  std::FILE* const pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("no pipe for " + words[0]);
  std::string text;
  std::array<char, 4096> part{};
  while (const std::size_t n = std::fread(part.data(), 1, part.size(), pipe)) text.append(part.data(), n);
  return {std::move(text), ::pclose(pipe) == 0};
}

LaunchNode node_of(const nlohmann::json& json) {
  LaunchNode node;
  json.at("name").get_to(node.name);
  json.at("package").get_to(node.package);
  json.at("type").get_to(node.type);
  // lidard's programs are identified by type, other nodes by package.
  if (node.package == "lidard") node.package = node.type;
  json.at("namespace").get_to(node.space);
  json.at("arguments").get_to(node.arguments);
  json.at("remaps").get_to(node.remaps);
  json.at("parameters").get_to(node.parameters);
  return node;
}

}  // namespace

std::string LaunchNode::resolved(const std::string& topic) const {
  const bool is_absolute = !topic.empty() && topic.front() == '/';
  const bool is_private = !topic.empty() && topic.front() == '~';
  const std::string full = is_absolute ? topic : is_private ? name + "/" + topic.substr(1) : space + topic;
  const auto remapped = remaps.find(full);
  return remapped == remaps.end() ? full : remapped->second;
}

LaunchFile read_launch(const std::string& file, const std::vector<std::string>& arguments) {
  if (!std::filesystem::is_regular_file(file))
    throw ConfigError(file + ": cannot be read; expected a launch file or a YAML file of parameters");
  std::vector<std::string> words{python, script(), std::filesystem::absolute(file)};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const auto [text, ended_well] = output_of(words);
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!ended_well || json.is_discarded())
    throw std::runtime_error(file + ": " + python + " did not read it; apt install python3-yaml");
  LaunchFile launch;
  for (const auto& [name, list] : {std::pair("changes", &launch.changes), {"remarks", &launch.remarks}}) {
    if (json.contains(name)) json.at(name).get_to(*list);
  }
  if (json.contains("missing")) throw std::runtime_error(json.at("missing").get<std::string>());
  if (json.contains("error")) throw ConfigError(file + ": " + json.at("error").get<std::string>());
  for (const auto& node : json.at("nodes")) launch.nodes.push_back(node_of(node));
  return launch;
}

}  // namespace lidard
