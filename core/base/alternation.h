// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/time.h"

namespace lidard {

/// Follows what identifies the device at an address: a hardware address, a serial number, what its driver
/// says of each packet. Identities that alternate mean two devices with one IP address.
class Alternation {
 public:
  /// Devices change back `returns` times until they count as two, each time within `memory`: a spare that is
  /// exchanged for the first device after a longer time is no rival.
  explicit Alternation(int returns = 1, Span memory = std::chrono::minutes(10))
      : enough_(returns), memory_(memory) {}
  /// Empty: not known.
  void observe(std::string_view identity, Stamp now) {
    if (identity.empty() || identity == identity_) return;
    returns_ = identity == before_ && now - changed_ < memory_ ? returns_ + 1 : 0;
    changed_ = now;
    before_ = std::exchange(identity_, identity);
    if (returns_ >= enough_) found_ = now;
  }
  /// Both identities in the order of the alphabet; empty: only one was seen of late.
  std::string both(Stamp now) const {
    if (!found_ || now - *found_ >= memory_) return {};
    return std::min(identity_, before_) + " and " + std::max(identity_, before_);
  }

 private:
  int enough_, returns_ = 0;
  Span memory_;
  std::string identity_, before_;
  Stamp changed_{};
  std::optional<Stamp> found_;
};

}  // namespace lidard
