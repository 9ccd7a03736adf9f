// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/counters.h"

namespace lidard {

/// A list of the counters that are not 0: "size 1, magic 2".
class Counted {
 public:
  void add(std::string_view words, std::uint64_t n) {
    if (n != 0) text_ += fmt::format("{}{} {}", text_.empty() ? "" : ", ", words, n);
  }
  template <class Owner, std::size_t n>
  void add(const NamedCounter<Owner> (&counters)[n], const Owner& owner) {
    for (const auto& counter : counters) add(counter.words, owner.*counter.value);
  }
  /// Empty: all are 0.
  const std::string& text() const { return text_; }
  /// " (size 1, magic 2)"; empty: all are 0.
  std::string in_brackets() const { return text_.empty() ? "" : " (" + text_ + ")"; }

 private:
  std::string text_;
};

}  // namespace lidard
