// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/base/time.h"
#include "drivers/flow.h"

namespace lidard {

/// Senders to a configured port that belong to no sensor.
class UnknownSenders {
 public:
  /// A sender is forgotten after this silence.
  static constexpr Span expires_after = std::chrono::seconds(60);

  void note(const Packet& packet);
  /// "192.168.1.9 -> port 2368 (412 packets)"; those that have sent at or after `since`.
  std::vector<std::string> names(Stamp since = {}) const;
  /// The first one that has sent datagrams to the port at or after `since`; empty: none.
  std::string sender_to(std::uint16_t port, Stamp since = {}) const;

 private:
  struct Sender {
    std::uint64_t packets = 0;
    Stamp last{};
  };

  std::map<Flow, Sender> senders_;
};

}  // namespace lidard
