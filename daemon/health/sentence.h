// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace lidard {

enum class Health : std::uint8_t { ok, warn, error, stale };

/// A sentence for people, a row of sentences.h. A figure stands as {name} or {name:format}, the format as
/// fmt has it.
struct Sentence {
  Health health;
  std::string_view words;   ///< the fact with its cause
  std::string_view remedy;  ///< what to do; empty: nothing
};

/// The names of a sentence's figures, in the order of their first mention.
class FigureNames {
 public:
  constexpr explicit FigureNames(const Sentence& sentence) {
    for (const std::string_view text : {sentence.words, sentence.remedy})
      for (std::size_t at = text.find('{'); at != text.npos; at = text.find('{', at + 1))
        add(name_at(text, at));
  }
  constexpr std::size_t count() const { return count_; }
  /// count(): there is no such figure.
  constexpr std::size_t index_of(std::string_view name) const {
    std::size_t i = 0;
    while (i < count_ && names_[i] != name) ++i;
    return i;
  }
  /// The name behind the brace at `open`.
  static constexpr std::string_view name_at(std::string_view text, std::size_t open) {
    return text.substr(open + 1, text.find_first_of(":}", open) - open - 1);
  }

 private:
  constexpr void add(std::string_view name) {
    if (index_of(name) == count_) names_[count_++] = name;
  }

  std::array<std::string_view, 8> names_{};
  std::size_t count_ = 0;
};

/// The words with their figures, and with the remedy unless `words_only`.
std::string formatted(const Sentence& sentence, bool words_only, fmt::format_args figures);

/// The words of a sentence of sentences.h without its remedy. `figures`: in the order of their first mention.
template <const Sentence& sentence, class... Figures>
std::string fact(const Figures&... figures) {
  static_assert(FigureNames(sentence).count() == sizeof...(Figures), "as many figures as the sentence names");
  return formatted(sentence, true, fmt::make_format_args(figures...));
}

/// As fact(), with the remedy.
template <const Sentence& sentence, class... Figures>
std::string text(const Figures&... figures) {
  static_assert(FigureNames(sentence).count() == sizeof...(Figures), "as many figures as the sentence names");
  return formatted(sentence, false, fmt::make_format_args(figures...));
}

}  // namespace lidard
