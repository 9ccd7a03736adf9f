// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/registry/nearest_models.h"

#include <algorithm>
#include <cctype>
#include <string>
#include <utility>

#include "core/base/nearest.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

constexpr std::size_t most_suggestions = 3;

/// People write "VLP-16", "vlp 16" and "VLP16": only letters and digits count.
std::string essence(std::string_view text) {
  std::string kept;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0) kept += static_cast<char>(std::tolower(byte));
  }
  return kept;
}

/// Distance of what was written from the best of a model's spellings: its name, or its product with and
/// without the vendor. A mere beginning ("velodyne") counts as one slip.
std::size_t distance_to(const std::string& written, const Model& model) {
  const std::string product = essence(model.product);
  std::size_t best = std::string::npos;
  for (const std::string& spelling : {essence(model.name), product, essence(model.vendor) + product}) {
    const bool begins = written.size() > 2 && written.size() < spelling.size() &&
                        spelling.compare(0, written.size(), written) == 0;
    best = std::min(best, begins ? std::size_t{1} : edit_distance(written, spelling));
  }
  return best;
}

}  // namespace

std::vector<std::string_view> nearest_models(std::string_view name) {
  const std::string written = essence(name);
  std::vector<std::pair<std::size_t, std::string_view>> ranked;
  for (const Model& model : models()) {
    const std::size_t distance = distance_to(written, model);
    if (is_plausible_slip(written, distance)) ranked.emplace_back(distance, model.name);
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<std::string_view> names;
  for (const auto& [distance, model] : ranked) {
    if (names.size() < most_suggestions) names.push_back(model);
  }
  return names;
}

}  // namespace lidard
