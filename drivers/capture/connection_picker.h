// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "drivers/driver.h"

namespace lidard {

/// A capture may hold several connections to one device (a configuration tool beside the driver, or one after
/// the other); half telegrams of two must not be mixed. Picks the chunks of one connection at a time: the
/// newest.
class ConnectionPicker {
 public:
  /// True if the chunk, which the device sent, is of the connection that counts; the first one of a
  /// connection is marked as the start of its stream.
  bool pick(Packet& packet) {
    if (peer_ && *peer_ == packet.to) return true;
    if (peer_ && !packet.stream_start) return false;
    peer_ = packet.to;
    packet.stream_start = true;
    return true;
  }
  /// The capture starts again.
  void restart() { peer_.reset(); }

 private:
  std::optional<Endpoint> peer_;
};

}  // namespace lidard
