// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include "core/base/time.h"

namespace lidard {

/// Follows what identifies the device at an address (hardware address, serial number). Identities that
/// alternate mean two devices with one IP address.
class Alternation {
 public:
  /// A spare that is exchanged for the first device after a longer time is no rival. Empty: not known.
  void observe(const std::string& identity, Stamp now) {
    if (identity.empty() || identity == identity_) return;
    if (identity == before_ && now - changed_ < news) returned_ = now;
    changed_ = now;
    before_ = std::exchange(identity_, identity);
  }
  /// Both identities; empty: only one was seen in the last ten minutes.
  std::string both(Stamp now) const {
    return returned_ && now - *returned_ < news ? identity_ + " and " + before_ : std::string();
  }

 private:
  static constexpr Span news = std::chrono::minutes(10);
  std::string identity_, before_;
  Stamp changed_{};
  std::optional<Stamp> returned_;
};

/// The sentence on two devices with one address; `who`: what shows it.
inline std::string two_devices_text(const std::string& address, const std::string& who) {
  return "two devices have the address " + address + " (" + who + "); give one of them another IP address";
}

}  // namespace lidard
