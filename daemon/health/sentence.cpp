// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/sentence.h"

namespace lidard {
namespace {

/// "{rate:.0f} of {limit}" becomes "{0:.0f} of {1}".
std::string numbered(std::string_view text, const FigureNames& names) {
  std::string out;
  for (;;) {
    const std::size_t open = text.find('{');
    out += text.substr(0, open);
    if (open == text.npos) return out;
    out += '{' + std::to_string(names.index_of(FigureNames::name_at(text, open)));
    text.remove_prefix(text.find_first_of(":}", open));
  }
}

}  // namespace

std::string formatted(const Sentence& sentence, bool words_only, fmt::format_args figures) {
  const FigureNames names(sentence);
  std::string text = numbered(sentence.words, names);
  if (!words_only && !sentence.remedy.empty()) text += "; " + numbered(sentence.remedy, names);
  return fmt::vformat(text, figures);
}

}  // namespace lidard
