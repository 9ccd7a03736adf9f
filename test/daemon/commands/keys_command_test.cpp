// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>

#include "core/base/number_text.h"
#include "daemon/commands/commands.h"
#include "test/daemon/config/config_support.h"
#include "test/daemon/config/key_places.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

using test::all_keys;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Not;

std::string printed(KeysFormat format) {
  std::ostringstream out;
  EXPECT_EQ(run_keys(format, out), 0);
  return out.str();
}

std::string file(const std::string& path) { return test::content(test::project_file(path)); }

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

/// What is answered to a key with this value in each of its places.
std::vector<std::string> answers_to(const nlohmann::json& key, const std::string& value) {
  std::vector<std::string> all;
  for (const std::string& place : test::places_of(key["section"]))
    all.push_back(test::error_of(test::with(place, std::string(key["key"]) + ": " + value)));
  return all;
}

/// As the message begins that refuses a value of a key.
std::string refusal(const nlohmann::json& key, const std::string& value) {
  return "." + std::string(key["key"]) + " is " + value + "; expected ";
}

TEST(KeysCommand, TellsTheLimitsThatTheParserKeeps) {
  int checked = 0;
  for (const auto& one : all_keys()) {
    if (!one.contains("max")) continue;
    SCOPED_TRACE(one);
    for (const char* bad : {".nan", ".inf", "-.inf", "much", "1m", "0x10", "[1]", "{}", "''"})
      EXPECT_THAT(answers_to(one, bad), Not(Contains("no error"))) << bad;
    if (one["kind"] == "angle") continue;  // the rules of angles are in config/answers
    const double low = one["min"], high = one["max"];
    const auto step = [&](double limit) {
      return one["kind"] == "whole" ? 1 : 1e-4 * std::max(1.0, std::abs(limit));
    };
    for (const double edge : {low, high}) {
      if (one["key"] == "free_required" || one["key"] == "skip") continue;  // less where other limits hold
      EXPECT_THAT(answers_to(one, number_text(edge)), Each(Not(HasSubstr(refusal(one, number_text(edge))))));
    }
    for (const double beyond : {low - step(low), high + step(high)}) {
      EXPECT_THAT(answers_to(one, number_text(beyond)),
                  AllOf(Contains(HasSubstr(refusal(one, number_text(beyond)))), Not(Contains("no error"))));
    }
    ++checked;
  }
  EXPECT_GE(checked, 45);
}

TEST(KeysCommand, TellsTheWordsThatTheParserKnows) {
  for (const auto& one : all_keys()) {
    if (!one.contains("words")) continue;
    SCOPED_TRACE(one);
    for (const std::string word : one["words"])
      EXPECT_THAT(answers_to(one, word), Each(Not(HasSubstr(refusal(one, '"' + word + '"')))));
    EXPECT_THAT(answers_to(one, "nonsense"), Contains(HasSubstr(refusal(one, "\"nonsense\""))));
  }
}

}  // namespace
}  // namespace lidard
