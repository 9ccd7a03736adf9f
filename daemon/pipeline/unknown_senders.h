// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "drivers/flow.h"

namespace lidard {

/// Senders on a configured port that no sensor claims.
class UnknownSenders {
 public:
  void note(const Packet& packet);
  /// "192.168.1.9 -> port 2368 (412 packets)".
  std::vector<std::string> names() const;
  /// The first of them that sends datagrams to the port; empty: there is none.
  std::string sender_to(std::uint16_t port) const;

 private:
  std::map<Flow, std::uint64_t> packets_;
  std::uint64_t not_named_ = 0;
};

}  // namespace lidard
