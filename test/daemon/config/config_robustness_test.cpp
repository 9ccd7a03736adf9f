// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <iterator>
#include <random>
#include <regex>
#include <sstream>

#include "test/daemon/config/config_support.h"
#include "test/support/captures.h"

namespace lidard {
namespace {

/// True if the text is a configuration; anything but a placed ConfigError fails the test.
bool is_accepted(const std::string& text) {
  static const std::regex placed("f(:[1-9][0-9]*:[1-9][0-9]*)?: [^\\n]+; expected [^\\n]+");
  try {
    const Config config = parse_config(text, "f");
    parse_config(to_yaml(config), "again");
    return true;
  } catch (const ConfigError& error) {
    std::istringstream lines(error.what());
    for (std::string line; std::getline(lines, line);)
      EXPECT_TRUE(std::regex_match(line, placed)) << error.what() << "\n--- from:\n" << text;
  } catch (const std::exception& error) {
    ADD_FAILURE() << error.what() << "\n--- from:\n" << text;
  }
  return false;
}

std::string example() { return test::content(test::project_file("config/demo.yaml")); }

TEST(ConfigRobustness, RandomBytesGiveAPlacedError) {
  const std::string marks = " \n:-[]{},#&*!|>'\"%@`ab?";
  std::mt19937 random(7);
  for (int i = 0; i < 4000; ++i) {
    std::string text(random() % 60, ' ');
    for (char& c : text) {
      const char any = static_cast<char>(random() % 256);
      c = i % 2 == 0 ? any : marks[random() % marks.size()];
    }
    EXPECT_FALSE(is_accepted(text)) << text;
  }
}

TEST(ConfigRobustness, MutatedExamplesAreAcceptedOrGiveAPlacedError) {
  const std::string original = example();
  ASSERT_TRUE(is_accepted(original));
  const std::string alphabet = " \n:-[]{},#&*!|>'\"0123456789.eainfx_/";
  std::mt19937 random(11);
  int accepted = 0;
  constexpr int rounds = 3000;
  for (int i = 0; i < rounds; ++i) {
    std::string text = original;
    for (std::size_t change = 0; change <= random() % 3; ++change) {
      const std::size_t at = random() % text.size();
      const std::size_t kind = random() % 4;
      if (kind == 0) text[at] = static_cast<char>(random() % 256);
      if (kind == 1) text[at] = alphabet[random() % alphabet.size()];
      if (kind == 2) text.erase(at, random() % 40);
      if (kind == 3) text.insert(at, text.substr(random() % text.size(), random() % 40));
    }
    accepted += is_accepted(text) ? 1 : 0;
  }
  EXPECT_GT(accepted, rounds / 100);  // changed comments and numbers
  EXPECT_LT(accepted, rounds / 2 + rounds / 4);
}

TEST(ConfigRobustness, EveryBeginningOfAnExampleIsAcceptedOrGivesAPlacedError) {
  const std::string original = example();
  for (std::size_t length = 0; length < original.size(); length += 3) is_accepted(original.substr(0, length));
}

TEST(ConfigRobustness, APipeIsNotWaitedFor) {
  const std::string path = ::testing::TempDir() + "lidard-pipe-" + std::to_string(getpid());
  ASSERT_EQ(mkfifo(path.c_str(), 0600), 0);
  EXPECT_THROW(load_config(path), ConfigError);
  unlink(path.c_str());
}

TEST(ConfigRobustness, DeepNestingAndSelfReferenceGiveAPlacedError) {
  EXPECT_FALSE(is_accepted(std::string(100000, '[')));
  EXPECT_FALSE(is_accepted("sensors: " + std::string(100000, '{')));
  EXPECT_FALSE(is_accepted("sensors: &a {a: *a}\n"));
  EXPECT_FALSE(is_accepted("sensors: {a: &a {topic: s, pose: *a}}\n"));
  EXPECT_FALSE(is_accepted("&a [*a]\n"));
}

}  // namespace
}  // namespace lidard
