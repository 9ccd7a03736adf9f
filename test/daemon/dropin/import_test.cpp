// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What nodes of launch files, and nodes that stand in for others, become.
#include "daemon/dropin/import.h"

#include <gtest/gtest.h>

#include <iomanip>
#include <sstream>

#include "test/support/answers.h"

namespace lidard {
namespace {

/// A node in a line: its name, PACKAGE/TYPE (- where a parameter file does not name them), and in any order
/// parameters KEY=VALUE, remappings FROM:=TO and other arguments; what has blanks stands in quotes.
LaunchNode node_of(const std::string& line) {
  std::istringstream words(line);
  LaunchNode node;
  std::string program;
  words >> node.name >> program;
  node.space = "/";
  if (const auto slash = program.find('/'); slash != std::string::npos)
    node.package = program.substr(0, slash), node.type = program.substr(slash + 1);
  for (std::string word; words >> std::quoted(word);) {
    const auto equals = word.find('=');
    if (equals == std::string::npos)
      node.arguments.push_back(word);
    else if (equals > 0 && word[equals - 1] == ':')
      node.remaps[word.substr(0, equals - 1)] = word.substr(equals + 1);
    else
      node.parameters[word.substr(0, equals)] = word.substr(equals + 1);
  }
  return node;
}

void add(std::string& all, const std::string& title, const std::vector<std::string>& sentences) {
  for (const std::string& sentence : sentences) all += title + ": " + sentence + "\n";
}

std::string without_last_end(const std::string& text) {
  return text.substr(0, text.find_last_not_of('\n') + 1);
}

/// The configuration of all nodes, which is one that is accepted, and what is said of it.
std::string imported(const std::string& text) {
  LaunchFile launch;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) launch.nodes.push_back(node_of(line));
  try {
    const ImportedConfig config = import_nodes(launch);
    std::string all = config.keys.yaml();
    if (config.entries() > 0) parse_config(all, "the configuration");
    add(all, "changes", config.changes);
    add(all, "stays", config.stays);
    add(all, "not needed", config.remarks);
    return without_last_end(all);
  } catch (const ConfigError& error) {
    return error.what();
  }
}

/// The configuration of a node that stands in for one of another package.
std::string stood_in(const std::string& text) {
  const LaunchNode node = node_of(text);
  const std::map<std::string, DropinSetup (*)(const NodeParameters&)> setups = {
      {"velodyne_node", velodyne_node_setup},
      {"sick_generic_caller", sick_scan_setup},
      {"sick_safetyscanners_node", safety_scanners_setup},
      {"nebula", nebula_setup},
      {"laserscan_multi_merger", laser_merger_setup},
      {"laserscan_virtualizer", laser_virtualizer_setup}};
  try {
    const DropinSetup setup = setups.at(node.type)(node.parameters);
    std::string all = setup.keys.yaml();
    parse_config(all, "the configuration");
    add(all, "replays", setup.replay.captures);
    add(all, "warning", setup.warnings);
    add(all, "not needed", setup.remarks);
    return without_last_end(all);
  } catch (const ConfigError& error) {
    return error.what();
  }
}

TEST(Import, MakesOfNodesWhatTheTableSays) {
  test::expect_answers("test/daemon/dropin/answers/import.txt", imported);
}

TEST(Import, MakesOfANodeThatStandsInForAnotherWhatTheTableSays) {
  test::expect_answers("test/daemon/dropin/answers/stand_in.txt", stood_in);
}

}  // namespace
}  // namespace lidard
