// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/packet_ring.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <new>
#include <type_traits>
#include <utility>

namespace lidard {
namespace {

/// Holds the largest datagram and the largest chunk of a TCP connection.
constexpr std::size_t block_bytes = 128 * 1024UL;
constexpr std::size_t fewest_blocks = 3;
/// Packets are sorted within this number of bytes, since the threads that add them have different delays.
constexpr std::size_t sorted_bytes = 1'000'000;

static_assert(std::is_trivially_copyable_v<Packet>, "packets are kept as bytes");

}  // namespace

/// Memory of its own, which returns to the system: blocks would leave holes in the heap.
struct PacketRing::Block {
  Block()
      : bytes(static_cast<std::uint8_t*>(
            mmap(nullptr, block_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0))) {
    if (bytes == MAP_FAILED) throw std::bad_alloc();
  }
  ~Block() { munmap(bytes, block_bytes); }
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;

  std::uint8_t* const bytes;
  std::size_t used = 0;
  Stamp newest;
  bool is_shared = false;  // a snapshot has it
};

PacketRing::PacketRing(std::size_t bytes) : most_blocks_(std::max(fewest_blocks, bytes / block_bytes)) {}

void PacketRing::add(const Packet& packet, Span longest) {
  const std::size_t size = sizeof packet + packet.payload.size();
  if (size > block_bytes) return;  // longer than any chunk of a socket
  if (!is_open_ || blocks_.back()->used + size > block_bytes) begin_block(packet.arrival - longest);
  if (!is_open_) return;
  Block& block = *blocks_.back();
  std::uint8_t* const to = &block.bytes[block.used];
  std::memcpy(to, &packet, sizeof packet);
  if (!packet.payload.empty()) std::memcpy(to + sizeof packet, packet.payload.data(), packet.payload.size());
  block.used += size;
  block.newest = std::max(block.newest, packet.arrival);
}

void PacketRing::begin_block(Stamp too_old) {
  std::shared_ptr<Block> next;
  if (!blocks_.empty() && (blocks_.front()->newest < too_old || blocks_.size() == most_blocks_)) {
    next = std::move(blocks_.front());
    blocks_.pop_front();
  }
  is_open_ = false;
  try {
    if (next == nullptr || next->is_shared) next = std::make_shared<Block>();
  } catch (const std::bad_alloc&) {
    if (!blocks_.empty()) blocks_.pop_front();  // a shorter time is kept
    return;
  }
  next->used = 0;
  next->newest = {};
  blocks_.push_back(std::move(next));
  is_open_ = true;
}

PacketRing::Snapshot PacketRing::snapshot() {
  is_open_ = false;
  for (const auto& block : blocks_) block->is_shared = true;
  return {blocks_.begin(), blocks_.end()};
}

void PacketRing::read(Snapshot snapshot, Stamp since, const std::function<void(const Packet&)>& use) {
  std::multimap<Stamp, std::pair<Packet, std::vector<std::uint8_t>>> waiting;
  std::size_t bytes = 0;  // in waiting
  const auto hand_on = [&](std::size_t most_bytes) {
    for (; bytes > most_bytes; waiting.erase(waiting.begin())) {
      auto& [packet, payload] = waiting.begin()->second;
      packet.payload = ByteView(payload.data(), payload.size());
      use(packet);
      bytes -= sizeof packet + payload.size();
    }
  };
  for (auto& block : snapshot) {
    for (std::size_t at = 0; at < block->used;) {
      Packet packet;
      std::memcpy(&packet, &block->bytes[at], sizeof packet);
      const std::uint8_t* const payload = block->bytes + at + sizeof packet;
      const std::size_t size = sizeof packet + packet.payload.size();
      at += size;
      if (packet.arrival < since) continue;
      waiting.emplace(packet.arrival,
                      std::pair(packet, std::vector(payload, payload + packet.payload.size())));
      bytes += size;
    }
    block.reset();
    hand_on(sorted_bytes);
  }
  hand_on(0);
}

}  // namespace lidard
