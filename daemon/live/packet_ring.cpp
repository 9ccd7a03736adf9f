// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/live/packet_ring.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <set>
#include <type_traits>

#include "drivers/flow.h"

namespace lidard {
namespace {

/// Holds the largest datagram and the largest chunk of a TCP connection.
constexpr std::size_t block_bytes = 128 * 1024UL;
/// One block is written to while another one is read.
constexpr std::size_t fewest_blocks = 3;
/// Packets are sorted within this number of bytes, since the threads that add them have different delays.
constexpr std::size_t sorted_bytes = 1'000'000;

static_assert(std::is_trivially_copyable_v<Packet>, "packets are kept as bytes");

}  // namespace

/// Sorts packets by arrival (stable).
class PacketRing::Reader {
 public:
  Reader(Stamp since, const std::function<void(const Packet&)>& use) : since_(since), use_(use) {}

  void read(const Block& block) {
    for (std::size_t at = 0; at < block.used;) {
      Packet packet;
      std::memcpy(&packet, block.bytes + at, sizeof packet);
      at += sizeof packet;
      if (packet.arrival >= since_) keep(packet, block.bytes + at);
      at += packet.payload.size();
    }
  }
  void lose(std::uint64_t packets) {
    if (!begun_) return;  // before the first packet of the snapshot
    lost_ += packets;
    unbroken_.clear();
  }
  void hand_on(std::size_t most_bytes) {
    for (; bytes_ > most_bytes; waiting_.erase(waiting_.begin())) {
      Kept& kept = waiting_.begin()->second;
      kept.packet.payload = ByteView(kept.payload.data(), kept.payload.size());
      use_(kept.packet);
      bytes_ -= sizeof(Kept) + kept.payload.size();
    }
  }
  std::uint64_t lost() const { return lost_; }

 private:
  struct Kept {
    Packet packet;
    std::vector<std::uint8_t> payload;
  };
  void keep(Packet packet, const std::uint8_t* payload) {
    begun_ = true;
    const bool follows = packet.transport == Transport::udp || !unbroken_.insert(flow_of(packet)).second;
    if (!follows && lost_ > 0) packet.stream_start = true;
    bytes_ += sizeof(Kept) + packet.payload.size();
    waiting_.emplace(packet.arrival, Kept{packet, {payload, payload + packet.payload.size()}});
  }

  const Stamp since_;
  const std::function<void(const Packet&)>& use_;
  std::multimap<Stamp, Kept> waiting_;
  std::size_t bytes_ = 0;  // in waiting_
  std::uint64_t lost_ = 0;
  bool begun_ = false;
  std::set<Flow> unbroken_;  // connections since the last gap
};

PacketRing::PacketRing(std::size_t bytes)
    : blocks_(std::max(fewest_blocks, bytes / (block_bytes + sizeof(Block)))) {
  memory_.reset(new std::uint8_t[blocks_.size() * block_bytes]);  // not touched yet
  for (std::size_t i = 0; i < blocks_.size(); ++i) blocks_[i].bytes = &memory_[i * block_bytes];
}

void PacketRing::add(const Packet& packet, Span longest) {
  const std::size_t size = sizeof packet + packet.payload.size();
  if (size > block_bytes) return;  // longer than any chunk of a socket
  if (current_ != nullptr && current_->used + size > block_bytes) close_block();
  if (current_ == nullptr) begin_block(packet.arrival - longest);
  std::uint8_t* const to = current_->bytes + current_->used;
  std::memcpy(to, &packet, sizeof packet);
  if (!packet.payload.empty()) std::memcpy(to + sizeof packet, packet.payload.data(), packet.payload.size());
  current_->used += size;
  ++current_->packets;
  current_->newest = std::max(current_->newest, packet.arrival);
}

void PacketRing::close_block() {
  filled_.push_back(current_);
  current_->busy.clear(std::memory_order_release);
  current_ = nullptr;
}

void PacketRing::begin_block(Stamp too_old) {
  const auto is_taken = [&](Block* block) {
    const bool wanted = block->newest < too_old || touched_ == blocks_.size();
    return wanted && !block->busy.test_and_set(std::memory_order_acquire);
  };
  const auto found = std::find_if(filled_.begin(), filled_.end(), is_taken);
  if (found != filled_.end()) {
    current_ = *found;
    filled_.erase(found);
  } else {
    current_ = &blocks_[touched_++];  // a reader uses one block at a time, so one is free
    current_->busy.test_and_set(std::memory_order_acquire);
  }
  current_->used = current_->packets = 0;
  current_->newest = Stamp();
  current_->number = ++number_;
}

PacketRing::Snapshot PacketRing::snapshot() {
  if (current_ != nullptr) close_block();
  Snapshot all;
  all.parts_.reserve(filled_.size());
  for (Block* const block : filled_)
    all.parts_.push_back({block, block->packets, block->number, block->newest});
  return all;
}

std::uint64_t PacketRing::read(const Snapshot& snapshot, Stamp since,
                               const std::function<void(const Packet&)>& use) {
  Reader reader(since, use);
  for (const auto& part : snapshot.parts_) {
    if (part.newest < since) continue;
    const bool free = !part.block->busy.test_and_set(std::memory_order_acquire);
    if (free && part.block->number == part.number)
      reader.read(*part.block);
    else
      reader.lose(part.packets);
    if (free) part.block->busy.clear(std::memory_order_release);
    reader.hand_on(sorted_bytes);
  }
  reader.hand_on(0);
  return reader.lost();
}

}  // namespace lidard
