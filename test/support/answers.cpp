// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/answers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <utility>
#include <vector>

#include "test/support/captures.h"

namespace lidard::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A text and what is answered to it.
struct Row {
  std::size_t line = 0;
  std::string text, all;
  std::vector<std::string> words, others;
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
    if (mark != "=> " && mark != "~> " && mark != "!> ") end_row();
    if (mark != "|  ") is_around_ = false;
    if (mark == "=> ") {
      row_.all += rest + "\n";
    } else if (mark == "~> ") {
      row_.words.push_back(rest);
    } else if (mark == "!> ") {
      row_.others.push_back(rest);
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
    if (row_.all.empty() && row_.words.empty() && row_.others.empty()) return;
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

}  // namespace

void expect_answers(const std::string& table, const std::function<std::string(const std::string&)>& answer) {
  const std::vector<Row> rows = Table(project_file(table)).rows;
  EXPECT_GT(rows.size(), 10U) << table;
  for (const Row& row : rows) {
    SCOPED_TRACE(table + ":" + std::to_string(row.line) + "\n" + row.text);
    const std::string said = answer(row.text) + "\n";
    for (const std::string& words : row.words) EXPECT_THAT(said, HasSubstr(words));
    for (const std::string& words : row.others) EXPECT_THAT(said, Not(HasSubstr(words)));
    if (!row.all.empty()) {
      EXPECT_EQ(said, row.all);
    }
  }
}

}  // namespace lidard::test
