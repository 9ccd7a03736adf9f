// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "daemon/commands/commands.h"
#include "daemon/config/config.h"
#include "daemon/offline/remarks.h"
#include "drivers/registry/registry.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

std::vector<std::string> examples() {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(test::project_file("config"))) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path().string());
  }
  return files;
}

/// The text of an example in which each option, a line like `# skip: 1`, is switched on.
std::string with_options(const std::string& path) {
  return std::regex_replace(test::content(path), std::regex("\n( +)# ([a-z_]+: )"), "\n$1$2");
}

/// The rows of the key tables, each as section.key; sections as `lidard keys` names them.
std::set<std::string> key_rows() {
  std::ostringstream listed;
  run_keys(KeysFormat::json, listed);
  std::set<std::string> rows;
  for (const auto& row : nlohmann::json::parse(listed.str()))
    rows.insert(std::string(row["section"]) + "." + std::string(row["key"]));
  return rows;
}

/// Collects the rows that are used beneath `node`, which holds keys of `section`.
void find_used(const YAML::Node& node, const std::string& section, const std::set<std::string>& rows,
               std::set<std::string>& used) {
  for (const auto& entry : node) {
    std::string row = section + "." + std::regex_replace(entry.first.Scalar(), std::regex("_deg$"), "");
    if (rows.count(row) == 0) row = section + "." + entry.first.Scalar();
    used.insert(row);
    if (!entry.second.IsMap()) continue;
    if (row != "merged_scans.NAME.source_settings") {
      find_used(entry.second, row, rows, used);
      continue;
    }
    for (const auto& source : entry.second) find_used(source.second, row + ".SOURCE", rows, used);
  }
}

std::vector<ScanGridSpec> grids_of(const Config& config) {
  std::vector<ScanGridSpec> grids;
  for (const auto& scan : config.merged_scans) grids.push_back(scan.output.grid);
  for (const auto& scan : config.virtual_scans) grids.push_back(scan.output.grid);
  return grids;
}

/// The number of ranges that slam_toolbox expects of a LaserScan with these (float) angles.
std::size_t expected_by_slam_toolbox(const PlanarScan& scan) {
  const double span = static_cast<double>(scan.angle_max) - static_cast<double>(scan.angle_min);
  const auto increment = static_cast<double>(scan.angle_increment);
  const bool full_turn = std::abs(span - 2 * M_PI) < increment - 1e-6;
  return static_cast<std::size_t>(std::lround(span / increment)) + (full_turn ? 0U : 1U);
}

TEST(ExampleConfigs, AreAllRead) {
  const std::vector<std::string> files = examples();
  EXPECT_GE(files.size(), 4U);
  for (const std::string& file : files) {
    const Config config = load_config(file);
    EXPECT_THAT(remarks_on(config), testing::IsEmpty());
    EXPECT_EQ(to_yaml(parse_config(to_yaml(config), "again")), to_yaml(config)) << file;
    EXPECT_NO_THROW(parse_config(with_options(file), file)) << "with its options";
  }
}

TEST(ExampleConfigs, ShowNearlyEveryKeyThereIs) {
  const std::set<std::string> rows = key_rows();
  std::set<std::string> used;
  for (const std::string& file : examples()) {
    const YAML::Node root = YAML::Load(with_options(file));
    for (const auto& section : root) {
      const std::string name = section.first.Scalar();
      if (name == "vehicle" || name == "blackbox") find_used(section.second, name, rows, used);
      if (name == "vehicle" || name == "blackbox") continue;
      for (const auto& entry : section.second) find_used(entry.second, name + ".NAME", rows, used);
    }
  }
  std::size_t shown = 0;
  std::string missing;
  for (const std::string& row : rows) {
    shown += used.count(row);
    if (used.count(row) == 0) missing += "\n  " + row;
  }
  std::cout << rows.size() << " keys, " << shown << " of them in an example; in none:" << missing << '\n';
  EXPECT_LE(rows.size(), 150U) << "a key stands in an example, or goes";
  EXPECT_GE(shown, 120U) << missing;
}

TEST(ExampleConfigs, NameTheAddressOfEachSensor) {
  for (const std::string& file : examples()) {
    for (const SensorConfig& sensor : load_config(file).sensors)
      EXPECT_TRUE(sensor.model == nullptr || sensor.ip_address || !sensor.packet_topic.empty())
          << file << ": " << sensor.name;
  }
}

TEST(ExampleConfigs, GiveScansThatSlamToolboxAccepts) {
  std::size_t checked = 0;
  for (const std::string& file : examples()) {
    for (const ScanGridSpec& spec : grids_of(load_config(file))) {
      const auto grid = make_grid(spec);
      ASSERT_TRUE(grid) << file << ": " << grid.reason();
      PlanarScan scan;
      grid->prepare(scan, false);
      const std::size_t expected = expected_by_slam_toolbox(scan);
      // A full turn without its repeated last beam is accepted with either count.
      EXPECT_TRUE(scan.ranges.size() == expected || (grid->full_circle && scan.ranges.size() == expected + 1))
          << file << ": " << scan.ranges.size() << " beams, slam_toolbox expects " << expected;
      EXPECT_LT(scan.ranges.size(), gmapping_beam_limit) << file;
      ++checked;
    }
  }
  EXPECT_GE(checked, 4U);
}

TEST(ExampleConfigs, TheDemoVehicleIsTheOneOfTheDocumentation) {
  const Config config = load_config(test::project_file("config/demo.yaml"));
  const SensorConfig* left = config.find_sensor("front_left");
  ASSERT_NE(left, nullptr);
  EXPECT_EQ(left->model, find_model("sick_microscan3"));
  EXPECT_EQ(left->ip_address, IpAddress::v4(192, 168, 0, 21));
  EXPECT_TRUE(left->pose->isApprox(make_pose({0, 1, 0.35}, {0, 0, M_PI / 4}), 1e-9));
  const SensorConfig* roof = config.find_sensor("roof");
  ASSERT_NE(roof, nullptr);
  EXPECT_EQ(roof->ip_port, 2368);
  EXPECT_EQ(config.merged_scans.at(0).cloud_destination_topic, "merged_cloud");
  EXPECT_EQ(config.virtual_scans.at(0).poses.size(), 2U);
}

}  // namespace
}  // namespace lidard
