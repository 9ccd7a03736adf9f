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

/// What lies between two packets that do not follow each other at once.
struct StreamHole {
  Hundredths from;          ///< first group of the packet before
  Hundredths last;          ///< last group of the packet before
  std::int64_t turned;      ///< 1/100 deg, from the first group before to the first group after, whole turns
                            ///< included
  std::int64_t groups;      ///< firing groups in that time, sent, hidden or lost: at least 1
  std::int64_t per_packet;  ///< groups of a packet: at least 1
};

/// Tells packets that got lost from the sector a sensor hides because its field of view is limited.
///
/// The stamps tell how many firing groups passed between two packets, the azimuth which of them fell into the
/// hidden sector; the others must have been sent, so what is missing of them is lost. The sector itself shows
/// where it lies inside a packet, since loss takes whole packets. A hole between packets may be either: it
/// counts as hidden until something is received inside it, and what was taken for hidden wrongly is then
/// counted after all. The edges of a sector are the outermost groups ever received, so right after its
/// discovery a sequence at the very edge may be taken for hidden: of importance only where a packet holds no
/// more than one (VLS-128, two returns).
///
/// Angles are whole hundredths of a degree: their sums are exact, so that a way around the circle gets on
/// with every step. The work of one call is bounded, whatever the packets hold.
class HiddenSectors {
 public:
  /// Packets known to be lost since the last call, from this or earlier holes.
  std::uint64_t hole(const StreamHole& hole);
  /// A packet came. Returns how many earlier packets are known to be lost now.
  std::uint64_t receive(const PacketAzimuths& azimuths);
  /// No packet follows: what is still in doubt counts as lost if it did not come again, if chance could have
  /// taken so many packets, if the sensor was seen there or if it hides another sector.
  std::uint64_t finish();
  void reset() { *this = HiddenSectors(); }

 private:
  struct Sector {
    Hundredths from = 0, width = 0;  // between the last group before and the first group after it
    Hundredths packet = 0;           // turn during a packet
    Hundredths slack = 0;            // may still be taken from it once it is known
    std::int64_t passes = 0;         // holes over the whole of it; many where it lay inside a packet
    bool known = false;              // it lay inside a packet or came too often for chance
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
  bool take_out(Hundredths azimuth);
  void take_out(Sector& sector, Hundredths azimuth);
  bool could_be_chance(const Sector& sector) const;
  bool was_seen(const Sector& sector) const;
  bool came_again(const Sector& sector) const;
  std::int64_t hidden_groups(const StreamHole& hole) const;
  void count_again();
  std::uint64_t news() { return lost_ - std::exchange(told_, lost_); }

  std::array<Sector, 16> sectors_{};  // none overlaps another
  std::array<Past, 64> past_{};       // holes with something hidden in them
  std::size_t next_past_ = 0;
  std::bitset<360> seen_;  // whole degrees that something was received of
  bool bursts_ = false;    // a hole as wide as a hidden sector turned out to be loss
  std::uint64_t received_ = 0, lost_ = 0, told_ = 0;
};

}  // namespace lidard::velodyne
