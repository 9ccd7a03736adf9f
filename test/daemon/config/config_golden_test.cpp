// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Every key with every kind of value, and examples with random mistakes: what is accepted, what it then means
// and what is answered to the rest stays as it is.
#include <gtest/gtest.h>

#include <iterator>
#include <random>
#include <sstream>

#include "daemon/offline/remarks.h"
#include "test/daemon/config/config_support.h"
#include "test/daemon/config/key_places.h"
#include "test/support/captures.h"
#include "test/support/golden.h"

namespace lidard {
namespace {

/// What `check` would say of a text, mistakes and remarks included.
std::string said_of(const std::string& text) {
  try {
    const Config config = parse_config(text, "f");
    std::string all = "accepted";
    for (const std::string& warning : remarks_on(config)) all += "; remark: " + warning;
    return all + "\n" + to_yaml(config);
  } catch (const ConfigError& error) {
    return error.what();
  }
}

const char* const values[] = {"-2000000000",
                              "-1.5",
                              "0",
                              "0.0004",
                              "0.2",
                              "1",
                              "2",
                              "6.3",
                              "100",
                              "2049",
                              "65536",
                              "1e10",
                              ".nan",
                              "true",
                              "x",
                              "'a b'",
                              "b",
                              "\"\"",
                              "[]",
                              "{}",
                              "[a, a]",
                              "[0, 0, 1]",
                              "[[0, 0], [1, 0], [0, 1]]",
                              "[[0, 0], [1, 1], [0, 1], [1, 0]]",
                              "{xyz: [0, 0, 1], rpy: [0, 0, 4]}",
                              "{a: {range_min: 2}}",
                              "{t: strict}",
                              "{x: {xyz: [1, 2, 3]}}",
                              "239.1.2.3",
                              "fe80::1"};

TEST(ConfigGolden, EveryKeyTakesAndMeansWhatItDidBefore) {
  std::string all;
  for (const auto& row : test::all_keys()) {
    const std::string section = row["section"], key = row["key"];
    std::vector<std::string> tried(std::begin(values), std::end(values));
    if (row.contains("words")) {
      for (const auto& word : row["words"]) tried.push_back(word);
    }
    test::Sums sums;
    std::string accepted;  // how many in each place
    for (const std::string& place : test::places_of(section)) {
      std::size_t count = 0;
      for (const std::string& value : tried) {
        const std::string said = said_of(test::with(place, key + ": " + value));
        sums.add_text("said", said);
        count += said.rfind("accepted", 0) == 0 ? 1U : 0U;
      }
      accepted += (accepted.empty() ? "" : ", ") + std::to_string(count);
    }
    all += section + "." + key + ": " + accepted + " accepted" + sums.text();
  }
  test::expect_golden("config_keys.txt", all);
}

/// The printed configuration, which follows the first line.
std::string printed_in(const std::string& said) { return said.substr(said.find('\n') + 1); }

TEST(ConfigGolden, PairsOfKeysAreJudgedAsBeforeAndReadBackAsTheyArePrinted) {
  std::map<std::string, std::vector<std::string>> keys;
  for (const auto& row : test::all_keys()) {
    const std::string section = row["section"], key = row["key"];
    if (!row.contains("words")) {
      for (const char* value : {"0.3", "2", "true", "[a]", "x"}) keys[section].push_back(key + ": " + value);
    } else {
      for (const auto& word : row["words"]) keys[section].push_back(key + ": " + std::string(word));
    }
  }
  std::string all;
  std::mt19937 random(5);
  for (const auto& [section, entries] : keys) {
    test::Sums sums;
    for (const std::string& place : test::places_of(section)) {
      for (int i = 0; i < 40; ++i) {
        std::string some = entries[random() % entries.size()];
        for (std::size_t more = random() % 4; more > 0; --more)
          some += ", " + entries[random() % entries.size()];
        const std::string said = said_of(test::with(place, some));
        sums.add_text("said", said);
        if (said.rfind("accepted", 0) != 0) continue;
        EXPECT_EQ(printed_in(said_of(printed_in(said))), printed_in(said)) << place << ": " << some;
      }
    }
    all += section + sums.text();
  }
  test::expect_golden("config_pairs.txt", all);
}

TEST(ConfigGolden, MistakesAreAnsweredAsBefore) {
  const std::string original = test::content(test::project_file("config/demo.yaml"));
  const std::string alphabet = " \n:-[]{},#0123456789.eainfx_/";
  std::mt19937 random(12);
  std::string all;
  for (int i = 0; i < 120; ++i) {
    std::string text = original;
    for (std::size_t change = 0; change <= random() % 3; ++change) {
      const std::size_t at = random() % text.size();
      const std::size_t kind = random() % 3;
      if (kind == 0) text[at] = alphabet[random() % alphabet.size()];
      if (kind == 1) text.erase(at, random() % 12);
      if (kind == 2) text.insert(at, text.substr(random() % text.size(), random() % 12));
    }
    const std::string said = said_of(text);
    all += said.rfind("accepted", 0) == 0 ? said.substr(0, said.find('\n')) + "\n" : said + "\n";
  }
  test::expect_golden("config_mistakes.txt", all);
}

}  // namespace
}  // namespace lidard
