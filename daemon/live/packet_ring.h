// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "drivers/driver.h"

namespace lidard {

/// The newest packets in one piece of memory that is allocated once. add() and snapshot() are called by one
/// thread at a time; read() may run in another one meanwhile. Neither waits: memory is reused in blocks, a
/// block that is being read is passed over, and one that was reused before it was read is lost to the reader.
class PacketRing {
 public:
  /// What the ring held at an instant, oldest first.
  class Snapshot;

  /// `bytes`: all memory of the ring, headers of packets included; read() takes 1 MB more. Throws
  /// std::bad_alloc.
  explicit PacketRing(std::size_t bytes);

  /// Blocks older than `longest` are reused before memory is touched that was not used yet.
  void add(const Packet& packet, Span longest);
  Snapshot snapshot();
  /// Hands out the packets that arrived at `since` or later, in the order of their arrival. Returns how many
  /// were reused behind the first one that was read. A connection with such a gap begins anew
  /// (Packet::stream_start).
  static std::uint64_t read(const Snapshot& snapshot, Stamp since,
                            const std::function<void(const Packet&)>& take);

 private:
  struct Block {
    std::uint8_t* bytes = nullptr;
    std::size_t used = 0;
    std::uint64_t packets = 0, number = 0;  // number: counts the uses of all blocks
    Stamp newest;
    std::atomic_flag busy = ATOMIC_FLAG_INIT;  // of who writes to it or reads it
  };
  class Reader;
  void close_block();
  void begin_block(Stamp too_old);

  std::unique_ptr<std::uint8_t[]> memory_;
  std::vector<Block> blocks_;
  std::size_t touched_ = 0;  // blocks that were used at all
  std::uint64_t number_ = 0;
  std::deque<Block*> filled_;  // oldest first
  Block* current_ = nullptr;   // busy
};

class PacketRing::Snapshot {
 public:
  bool empty() const { return parts_.empty(); }

 private:
  friend class PacketRing;
  struct Part {
    Block* block;
    std::uint64_t packets, number;
    Stamp newest;
  };
  std::vector<Part> parts_;
};

}  // namespace lidard
