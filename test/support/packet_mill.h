// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/driver.h"
#include "drivers/model.h"
#include "test/sim/world/rng.h"

namespace lidard::test {

/// A packet with its own bytes.
struct OwnPacket {
  std::vector<std::uint8_t> bytes;
  Packet head;  // without payload
};

/// The packets that one capture holds for the devices of one protocol.
struct ProtocolPackets {
  std::string_view protocol;
  std::vector<OwnPacket> packets;
};

/// All captures of pcaps/, taken apart.
const std::vector<ProtocolPackets>& all_parts();

/// An endless stream for one device as bad days make it out of the shipped captures: bursts of loss, repeats,
/// old packets, other sensors' and foreign ones, cut and damaged bytes with right checksums or wrong ones,
/// times that jump, and for Velodynes azimuths and stamps of no sense in packets that are well formed. What
/// comes how often is drawn for each stream. The same seed makes the same stream.
class PacketMill {
 public:
  PacketMill(const Model& model, std::uint64_t seed);
  /// Valid until the next call.
  const Packet& next();

 private:
  enum Trick { burst, repeat, old, neighbour, foreign, cut, flip, word, smear, scramble, hole, leap, tricks };
  bool is_due(Trick trick) { return rng_.uniform() < chance_[trick]; }
  std::uint64_t below(std::uint64_t n) { return rng_.bits() % n; }
  const OwnPacket& choose();
  void restamp();
  void damage();
  void scramble_velodyne();
  void set_times();

  const Model& model_;
  sim::Rng rng_;
  std::array<double, tricks> chance_{};
  const ProtocolPackets* main_ = nullptr;
  const ProtocolPackets* other_ = nullptr;
  std::size_t at_ = 0;
  std::uint64_t rounds_ = 0;
  std::uint32_t scrambled_us_ = 0;
  Stamp now_{1'767'225'600'000'000'000};
  std::vector<std::uint8_t> bytes_;
  std::vector<std::uint8_t> rest_;  // of a chunk that was cut in two
  Packet packet_;
};

}  // namespace lidard::test
