// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/base/number_text.h"
#include "daemon/commands/commands.h"
#include "test/daemon/config/config_support.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::string printed(KeysFormat format) {
  std::ostringstream out;
  EXPECT_EQ(run_keys(format, out), 0);
  return out.str();
}

std::string file(const std::string& path) { return test::content(test::project_file(path)); }

const nlohmann::json& all_keys() {
  static const nlohmann::json keys = nlohmann::json::parse(printed(KeysFormat::json));
  return keys;
}

const nlohmann::json& key(const std::string& section, const std::string& name) {
  for (const auto& one : all_keys()) {
    if (one["section"] == section && one["key"] == name) return one;
  }
  throw std::runtime_error("no key " + section + "." + name);
}

TEST(KeysCommand, PrintsThePagesThatAreShipped) {
  EXPECT_EQ(file("config/KEYS.md"), printed(KeysFormat::markdown))
      << "lidard keys --markdown > config/KEYS.md";
  EXPECT_THAT(file("daemon/lidard.yaml.5"), HasSubstr(printed(KeysFormat::man)))
      << "what `lidard keys --man` prints stands in the manual page";
}

TEST(KeysCommand, KnowsLimitsDefaultsAndWhatIsLive) {
  const auto& range = key("merged_scans.NAME", "range_max");
  EXPECT_EQ(range["max"], 10000);
  EXPECT_EQ(range["unit"], "m");
  EXPECT_TRUE(range["live"]);
  EXPECT_FALSE(key("merged_scans.NAME", "range_noise")["live"]);
  EXPECT_EQ(key("merged_scans.NAME", "range_noise")["default"], "0.02");
  EXPECT_EQ(key("virtual_scans.NAME.ground", "model")["required"], true);
  EXPECT_EQ(key("virtual_scans.NAME.ground", "model")["words"], nlohmann::json({"none", "plane", "slope"}));
  EXPECT_THAT(printed(KeysFormat::table),
              HasSubstr("  policy: complete, rate, trigger (default: complete)\n"));
}

TEST(KeysCommand, NamesTheModelsThatTakeAKey) {
  EXPECT_THAT(key("sensors.NAME", "scan_ring")["models"].dump(), HasSubstr("velodyne_vls128"));
  const std::string control = key("sensors.NAME.control", "rpm")["models"].dump();
  EXPECT_THAT(control, HasSubstr("velodyne_vlp16"));
  EXPECT_THAT(control, Not(HasSubstr("hdl64")));
  EXPECT_FALSE(key("sensors.NAME", "frame_id").contains("models"));
}

TEST(KeysCommand, SaysOneLineOfEveryKey) {
  EXPECT_GT(all_keys().size(), 120U);
  for (const auto& one : all_keys()) {
    const std::string meaning = one["meaning"];
    EXPECT_FALSE(meaning.empty()) << one;
    EXPECT_EQ(meaning.find('\n'), std::string::npos) << one;
    EXPECT_FALSE(one["value"].get<std::string>().empty()) << one;
  }
}

/// The message for a merged or a virtual scan with this key.
std::string error_with(const std::string& section, const std::string& name, const std::string& value) {
  const bool merged = section == "merged_scans.NAME";
  return merged ? test::merged_error("laserscan_topics: rear, " + name + ": " + value)
                : test::virtual_error("cloud_topic: roof, virtual_laser_scan: [a], profile: strict, " + name +
                                      ": " + value);
}

TEST(KeysCommand, TellsTheLimitsThatTheParserKeeps) {
  int checked = 0;
  for (const auto& one : all_keys()) {
    const std::string section = one["section"];
    const bool output = section == "merged_scans.NAME" || section == "virtual_scans.NAME";
    if (!output || !one.contains("max") || one["kind"] == "angle" || one["key"] == "free_required") continue;
    const std::string name = one["key"];
    const std::string limits = (section == "merged_scans.NAME" ? "m." : "v.") + name + " is ";
    for (const double edge : {one["min"].get<double>(), one["max"].get<double>()})
      EXPECT_THAT(error_with(section, name, number_text(edge)), Not(HasSubstr(limits))) << one;
    EXPECT_THAT(error_with(section, name, number_text(one["max"].get<double>() * 1.5 + 1)),
                HasSubstr(limits));
    EXPECT_THAT(error_with(section, name, number_text(one["min"].get<double>() - 1)), HasSubstr(limits));
    ++checked;
  }
  EXPECT_GE(checked, 19);
}

TEST(KeysCommand, TellsTheWordsThatTheParserKnows) {
  for (const auto& one : all_keys()) {
    const std::string section = one["section"];
    if (!one.contains("words") || (section != "merged_scans.NAME" && section != "virtual_scans.NAME"))
      continue;
    const std::string name = one["key"];
    if (section == "virtual_scans.NAME" && name == "profile") continue;  // which error_with() sets itself
    const std::string refused = name + " is \"";
    for (const std::string word : one["words"])
      EXPECT_THAT(error_with(section, name, word), Not(HasSubstr(refused))) << one;
    EXPECT_THAT(error_with(section, name, "nonsense"), HasSubstr(refused + "nonsense\"; expected ")) << one;
  }
}

}  // namespace
}  // namespace lidard
