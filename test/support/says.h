// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gmock/gmock.h>

#include "daemon/health/sentences.h"

namespace lidard::test {

/// The pieces of a text between its figures.
inline std::vector<std::string_view> pieces_of(std::string_view text) {
  std::vector<std::string_view> pieces;
  for (std::size_t end = 0; end != text.npos;) {
    const std::size_t figure = text.find('{');
    pieces.push_back(text.substr(0, figure));
    end = figure == text.npos ? text.npos : text.find('}', figure);
    if (end != text.npos) text.remove_prefix(end + 1);
  }
  return pieces;
}

/// True of a text that has the sentence's words and remedy, with any figures.
MATCHER_P(Says, sentence, std::string(sentence.words) + "; " + std::string(sentence.remedy)) {
  std::string_view rest = arg;
  for (const std::string_view part : {sentence.words, sentence.remedy}) {
    for (const std::string_view piece : pieces_of(part)) {
      const std::size_t at = rest.find(piece);
      if (at == rest.npos) return false;
      rest.remove_prefix(at + piece.size());
    }
  }
  return true;
}

}  // namespace lidard::test
