// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/diagnostics.h"

#include <algorithm>

namespace lidard {

std::vector<DiagnosticItem> joined(const std::vector<DiagnosticItem>& items,
                                   std::vector<DiagnosticItem> more) {
  std::vector<DiagnosticItem> all = items;
  for (DiagnosticItem& item : more) {
    const auto known = std::find_if(all.begin(), all.end(),
                                    [&](const DiagnosticItem& one) { return one.name == item.name; });
    if (known == all.end()) {
      all.push_back(std::move(item));
      continue;
    }
    if (item.health > known->health) known->set(item.health, item.message);
    known->values.insert(known->values.end(), item.values.begin(), item.values.end());
  }
  return all;
}

}  // namespace lidard
