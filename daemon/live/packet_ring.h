// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "core/base/time.h"
#include "drivers/driver.h"

namespace lidard {

/// The newest packets in memory, which is reused in blocks. A block that was not read yet when its turn comes
/// stays with the snapshot and gets new memory in its place: a disk that is slower than the packets doubles
/// the memory of the ring for a while. For one thread at a time.
class PacketRing {
 public:
  /// Some packets as bytes.
  struct Block;
  /// The content of the ring at an instant.
  using Snapshot = std::vector<std::shared_ptr<const Block>>;

  /// `bytes`: the memory of the ring, including headers of packets.
  explicit PacketRing(std::size_t bytes);

  /// Adds a packet. Blocks older than `longest` are reused before unused memory.
  void add(const Packet& packet, Span longest);
  Snapshot snapshot();
  /// Passes the packets from `since` on to `use` in order of arrival, which the threads that add them do not
  /// keep. Any thread may call it.
  static void read(Snapshot snapshot, Stamp since, const std::function<void(const Packet&)>& use);

 private:
  void begin_block(Stamp too_old);

  std::size_t most_blocks_;
  std::deque<std::shared_ptr<Block>> blocks_;  // oldest first
  bool is_open_ = false;                       // the newest one may be added to
};

}  // namespace lidard
