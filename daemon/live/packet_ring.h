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

/// The newest packets in memory that is allocated once. Only one thread at a time may call add() and
/// snapshot(); read() may run in another thread. No function waits: memory is reused in blocks, a block that
/// is being read is skipped, and a block that was reused before it was read is lost to the reader.
class PacketRing {
 public:
  /// The content of the ring at an instant, oldest first.
  class Snapshot;

  /// `bytes`: the memory of the ring, including headers of packets; read() needs 1 MB more. Throws
  /// std::bad_alloc.
  explicit PacketRing(std::size_t bytes);

  /// Adds a packet. Blocks older than `longest` are reused before unused memory.
  void add(const Packet& packet, Span longest);
  Snapshot snapshot();
  /// Passes the packets from `since` on to `use` in order of arrival. Returns the number of packets after the
  /// first one that were lost by reuse; connections restart after such a gap (Packet::stream_start).
  static std::uint64_t read(const Snapshot& snapshot, Stamp since,
                            const std::function<void(const Packet&)>& use);

 private:
  struct Block {
    std::uint8_t* bytes = nullptr;
    std::size_t used = 0;
    std::uint64_t packets = 0, number = 0;  // number: sequence number among the uses of all blocks
    Stamp newest;
    std::atomic_flag busy = ATOMIC_FLAG_INIT;  // being written or read
  };
  class Reader;
  void close_block();
  void begin_block(Stamp too_old);

  std::unique_ptr<std::uint8_t[]> memory_;
  std::vector<Block> blocks_;
  std::size_t touched_ = 0;  // number of blocks used so far
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
