// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/base/counters.h"

namespace lidard::sick {

/// Follows a counter of telegrams: what is missing, what comes twice, what comes late.
class TelegramOrder {
 public:
  enum class Verdict { next, late, duplicate, restart };

  /// The next telegram that came in; `counters` gets what is lost and what is late.
  Verdict add(std::uint64_t counter, Counters& counters);
  void reset() { started_ = false; }

 private:
  bool started_ = false;
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;  // bit n: newest_ - n came
};

}  // namespace lidard::sick
