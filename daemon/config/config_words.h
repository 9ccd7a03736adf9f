// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "daemon/config/yaml_reader.h"

namespace lidard {

/// A choice and its word in a configuration.
template <class Choice>
struct Word {
  const char* word;
  Choice choice;
};

/// "a, b or c".
template <class Words>
std::string list_of(const Words& words) {
  std::string list;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) list += i + 1 == words.size() ? " or " : ", ";
    list += words[i].word;
  }
  return list;
}

/// The choice that `value` names; throws if it names none.
template <class Choice, std::size_t n>
Choice read_word(const Value& value, const std::array<Word<Choice>, n>& words) {
  const std::string expected = list_of(words);
  const std::string text = value.text(expected);
  for (const auto& one : words) {
    if (text == one.word || text == std::string(".") + one.word) return one.choice;
  }
  value.fail("is " + value.quoted(), expected);
}

template <class Choice, std::size_t n>
const char* word_in(Choice choice, const std::array<Word<Choice>, n>& words) {
  for (const auto& one : words) {
    if (one.choice == choice) return one.word;
  }
  return "";
}

}  // namespace lidard
