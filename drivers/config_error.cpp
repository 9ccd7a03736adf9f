// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/config_error.h"

#include <algorithm>
#include <tuple>

namespace lidard {
namespace {

constexpr std::size_t most_reported = 20;

std::string text_of(std::vector<ConfigError::Mistake> mistakes) {
  std::stable_sort(mistakes.begin(), mistakes.end(), [](const auto& a, const auto& b) {
    return std::tie(a.location.line, a.location.column) < std::tie(b.location.line, b.location.column);
  });
  std::string all;
  for (std::size_t i = 0; i < std::min(mistakes.size(), most_reported); ++i)
    all += (i == 0 ? "" : "\n") + mistakes[i].text;
  if (mistakes.size() > most_reported)
    all += "\n" + mistakes[0].location.file + ": " + std::to_string(mistakes.size() - most_reported) +
           " more mistakes; expected these to be corrected first";
  return all;
}

}  // namespace

ConfigError::ConfigError(std::vector<Mistake> mistakes)
    : std::runtime_error(text_of(mistakes)), mistakes_(std::move(mistakes)) {}

}  // namespace lidard
