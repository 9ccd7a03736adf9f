// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {

/// The gap between two packets that are not consecutive.
struct StreamHole {
  Hundredths from;      ///< first group of the packet before
  Hundredths last;      ///< last group of the packet before
  std::int64_t turned;  ///< 1/100 deg, from the first group before to the first group after, with full turns
  std::int64_t groups;  ///< firing groups in that time, sent, hidden or lost: at least 1
  std::int64_t per_packet;  ///< groups of a packet: at least 1
};

/// Distinguishes lost packets from a sector that a limited field of view hides.
///
/// The stamps show how many firing groups passed between two packets, and the azimuth shows which of them are
/// in the hidden sector; missing groups outside of it are lost. A gap inside a packet is a hidden sector,
/// since loss affects complete packets. A hole between packets may be either: it counts as hidden until a
/// group inside it is received, and then as lost after all. The edges of a sector are the outermost groups
/// received so far, so a new sector may hide a sequence at its edge; this matters only if a packet holds one
/// sequence (VLS-128, two returns).
///
/// Angles are integer hundredths of a degree with exact sums. The work of one call is bounded for all input.
class HiddenSectors {
 public:
  /// Adds a hole. Returns the number of packets found to be lost since the last call.
  std::uint64_t hole(const StreamHole& hole);
  /// Adds a packet. Returns the number of packets found to be lost since the last call.
  std::uint64_t receive(const PacketAzimuths& azimuths);
  /// End of the stream: an uncertain sector counts as loss if it did not recur, if chance can explain it, if
  /// groups were received in it or if another sector is hidden.
  std::uint64_t finish();
  void reset() { *this = HiddenSectors(); }

 private:
  struct Sector {
    Hundredths from = 0, width = 0;  // from the last group before to the first group after the sector
    Hundredths packet = 0;           // angle of a packet
    Hundredths slack = 0;            // by which a known sector may still shrink
    std::int64_t passes = 0;         // holes over the full sector; a large number after a gap inside a packet
    bool known = false;              // seen inside a packet or too often for chance
    bool used = false;

    Hundredths end() const { return (from + width) % whole_turn; }
  };
  struct Past {
    StreamHole hole;
    std::int64_t counted = 0;  // packets of it that count as lost
    bool used = false;
  };

  void learn(Hundredths from, Hundredths to, Hundredths packet);
  void add_candidates(const StreamHole& hole);
  void add_sector(Hundredths from, Hundredths width, Hundredths packet);
  void pass(Sector& sector);
  bool exclude(Hundredths azimuth);
  void exclude(Sector& sector, Hundredths azimuth);
  bool could_be_chance(const Sector& sector) const;
  bool was_seen(const Sector& sector) const;
  bool came_again(const Sector& sector) const;
  std::int64_t hidden_groups(const StreamHole& hole) const;
  void count_again();
  std::uint64_t new_losses() { return lost_ - std::exchange(reported_, lost_); }

  std::array<Sector, 16> sectors_{};  // disjoint
  std::array<Past, 64> past_{};       // holes with hidden groups
  std::size_t next_past_ = 0;
  std::bitset<360> seen_;  // degrees with received groups
  bool bursts_ = false;    // a hole as wide as a hidden sector was loss
  std::uint64_t received_ = 0, lost_ = 0, reported_ = 0;
};

}  // namespace lidard::velodyne
