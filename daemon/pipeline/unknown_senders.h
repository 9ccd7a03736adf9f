// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "drivers/driver.h"

namespace lidard {

/// Senders on a configured port that no sensor claims.
class UnknownSenders {
 public:
  void note(const Packet& packet);
  /// "192.168.1.9 -> port 2368 (412 packets)".
  std::vector<std::string> names() const;

 private:
  /// Sender's address with the destination port, or with its own where it was a connection.
  std::map<std::pair<Transport, Endpoint>, std::uint64_t> packets_;
  std::uint64_t not_named_ = 0;
};

}  // namespace lidard
