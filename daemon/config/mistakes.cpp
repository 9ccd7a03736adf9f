// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/mistakes.h"

#include <algorithm>
#include <tuple>

namespace lidard {
namespace {

constexpr std::size_t most_reported = 20;

}  // namespace

std::string Place::to_string() const {
  return file + ":" + std::to_string(line) + ":" + std::to_string(column);
}

PlacedError::PlacedError(const Place& where, const std::string& what)
    : ConfigError(where.to_string() + ": " + what), place(where) {}

void Mistakes::end_if_invalid(const std::string& path) const {
  const auto next = invalid_.lower_bound(path);
  if (next != invalid_.end() && next->compare(0, path.size(), path) == 0) throw AlreadyNoted();
}

void Mistakes::throw_if_any() {
  if (noted_.empty()) return;
  std::stable_sort(noted_.begin(), noted_.end(), [](const auto& a, const auto& b) {
    return std::tie(a.first.line, a.first.column) < std::tie(b.first.line, b.first.column);
  });
  noted_.erase(std::unique(noted_.begin(), noted_.end(),
                           [](const auto& a, const auto& b) { return a.second == b.second; }),
               noted_.end());
  std::string all;
  for (std::size_t i = 0; i < std::min(noted_.size(), most_reported); ++i)
    all += (i == 0 ? "" : "\n") + noted_[i].second;
  if (noted_.size() > most_reported)
    all += "\n" + noted_[0].first.file + ": " + std::to_string(noted_.size() - most_reported) +
           " more mistakes; expected these to be corrected first";
  throw ConfigError(all);
}

}  // namespace lidard
