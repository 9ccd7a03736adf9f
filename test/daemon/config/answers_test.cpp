// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What is answered to configurations and calibrations, without the name of the file.
#include "test/support/answers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "daemon/config/values.h"
#include "daemon/offline/field_sight.h"
#include "daemon/offline/forecast.h"
#include "daemon/offline/remarks.h"
#include "test/daemon/config/calibration_support.h"
#include "test/daemon/config/config_support.h"

namespace lidard::test {
namespace {

/// What `lidard check` writes of a configuration, or the mistake in it.
std::string checked(const std::string& text) {
  try {
    const Config config = parse_config(text, "f");
    const EmptyField field(config);
    std::string all;
    for (const auto& list :
         {remarks_on(config), host_remarks_on(config), forecast(config, sights_of(config, field))})
      for (const std::string& sentence : list) all += (all.empty() ? "" : "\n") + sentence;
    return all.empty() ? "nothing" : all;
  } catch (const ConfigError& error) {
    return error.what();
  }
}

/// Each table, and who answers.
struct Answerer {
  const char* table;
  std::string (*answer)(const std::string& text);
};

class Answers : public ::testing::TestWithParam<Answerer> {};

TEST_P(Answers, AreThoseOfTheTable) {
  test::expect_answers(std::string("test/daemon/config/answers/") + GetParam().table + ".txt",
                       [](const std::string& text) {
                         return std::regex_replace(GetParam().answer(text), std::regex("(^|\n)f:"), "$1");
                       });
}

INSTANTIATE_TEST_SUITE_P(Config, Answers,
                         ::testing::Values(Answerer{"file", error_of}, Answerer{"sensors", error_of},
                                           Answerer{"outputs", error_of}, Answerer{"remarks", checked},
                                           Answerer{"check", checked},
                                           Answerer{"calibrations", calibration_error}),
                         [](const auto& each) { return std::string(each.param.table); });

TEST(ManyMistakes, EndAtTwenty) {
  std::string text = "sensors:\n";
  for (int i = 0; i < 30; ++i)
    text += "  s" + std::to_string(i) + ": {topic: t" + std::to_string(i) + ", clok: 1}\n";
  const std::string all = error_of(text);
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), 20);
  EXPECT_THAT(all, ::testing::HasSubstr("\nf:21:"));
  EXPECT_THAT(all, ::testing::EndsWith("f: 10 more mistakes; expected these to be corrected first"));
}

TEST(RemovedKeys, OfOneSectionMayBeKeysOfAnother) {
  EXPECT_NE(instead_of("merged_scans.m.source_settings.left.veil_filter"), "");
  EXPECT_EQ(instead_of("merged_scans.m.veil_filter"), "");
  EXPECT_NE(instead_of("merged_scans.m.source_settings.left.intensity_max"), "");
  EXPECT_EQ(instead_of("sensors.a.filter.intensity_min"), "");
}

}  // namespace
}  // namespace lidard::test
