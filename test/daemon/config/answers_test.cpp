// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What is answered to configurations and calibrations: the rows of answers/*.txt. Lines of such a file that
// begin with
//   ==  are a title, after which nothing stands around the rows
//   |   stand around the rows that follow, which go where the % is
//   =>  are what is answered to the lines before, all of it without the name of the file
//   ~>  are words of what is answered
// All other lines are the text of a row.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <sstream>
#include <utility>

#include "daemon/config/values.h"
#include "daemon/offline/field_sight.h"
#include "daemon/offline/forecast.h"
#include "daemon/offline/remarks.h"
#include "test/daemon/config/calibration_support.h"
#include "test/daemon/config/config_support.h"
#include "test/support/captures.h"

namespace lidard::test {
namespace {

/// A text and what is answered to it.
struct Row {
  std::size_t line = 0;
  std::string text, all;
  std::vector<std::string> words;
};

class Table {
 public:
  explicit Table(const std::string& path) {
    std::istringstream lines(content(path));
    for (std::string line; std::getline(lines, line); ++number_) add(line);
    end_row();
  }
  std::vector<Row> rows;

 private:
  void add(const std::string& line) {
    const std::string mark = line.substr(0, 3), rest = line.size() > 3 ? line.substr(3) : "";
    if (mark != "=> " && mark != "~> ") end_row();
    if (mark != "|  ") is_around_ = false;
    if (mark == "=> ") {
      row_.all += rest + "\n";
    } else if (mark == "~> ") {
      row_.words.push_back(rest);
    } else if (mark == "== ") {
      around_.clear();
    } else if (mark == "|  ") {
      around_ = (std::exchange(is_around_, true) ? around_ : "") + rest + "\n";
    } else if (!line.empty() || !row_.text.empty()) {
      row_.line = number_;
      row_.text += line + "\n";
    }
  }
  /// A row ends where its answer ends.
  void end_row() {
    if (row_.all.empty() && row_.words.empty()) return;
    if (!around_.empty()) {
      row_.text.pop_back();
      row_.text = std::string(around_).replace(around_.find('%'), 1, row_.text);
    }
    rows.push_back(std::exchange(row_, {}));
  }

  std::size_t number_ = 1;
  bool is_around_ = false;
  std::string around_;
  Row row_;
};

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
  const std::string name = std::string("test/daemon/config/answers/") + GetParam().table + ".txt";
  const Table table(project_file(name));
  EXPECT_GT(table.rows.size(), 10U);
  for (const Row& row : table.rows) {
    SCOPED_TRACE(name + ":" + std::to_string(row.line) + "\n" + row.text);
    const std::string answer =
        std::regex_replace(GetParam().answer(row.text), std::regex("(^|\n)f:"), "$1") + "\n";
    for (const std::string& words : row.words) EXPECT_THAT(answer, ::testing::HasSubstr(words));
    if (!row.all.empty()) {
      EXPECT_EQ(answer, row.all);
    }
  }
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
