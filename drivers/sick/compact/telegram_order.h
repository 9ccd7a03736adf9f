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
  Verdict add(std::uint64_t counter, Counters& counters) {
    const bool ahead = counter > newest_;
    const std::uint64_t distance = ahead ? counter - newest_ : newest_ - counter;
    if (!started_ || (ahead ? distance > longest_gap : distance >= window)) {
      const bool restart = started_;
      started_ = true;
      newest_ = counter;
      seen_ = 1;
      return restart ? Verdict::restart : Verdict::next;
    }
    if (ahead) {
      counters.lost_packets += distance - 1;
      seen_ = distance < window ? seen_ << distance : 0;
      seen_ |= 1;
      newest_ = counter;
      return Verdict::next;
    }
    const std::uint64_t bit = std::uint64_t{1} << distance;
    if ((seen_ & bit) != 0) return Verdict::duplicate;
    seen_ |= bit;
    ++counters.reordered;
    // It was counted as lost, unless it left before the first one that came.
    if (counters.lost_packets > 0) --counters.lost_packets;
    return Verdict::late;
  }
  void reset() { started_ = false; }

 private:
  /// Telegrams that are remembered; what is older than that is not late but another count.
  static constexpr std::uint64_t window = 64;
  /// A step ahead beyond that is another count too: some minutes of the fastest device.
  static constexpr std::uint64_t longest_gap = 100'000;

  bool started_ = false;
  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;  // bit n: newest_ - n came
};

}  // namespace lidard::sick
