// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/container/static_vector.hpp>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {

/// The gap between two packets that are not consecutive.
struct StreamHole {
  Hundredths from;      ///< first group of the packet before
  std::int64_t turned;  ///< 1/100 deg, from the first group before to the first group after, with full turns
  std::int64_t groups;  ///< firing groups in that time, sent, hidden or lost: at least 1
  std::int64_t per_packet;  ///< groups of a packet: at least 1
};

/// Distinguishes lost packets from a sector that a limited field of view hides.
///
/// The stamps show how many firing groups passed between two packets, and the azimuth shows which of them are
/// in a sector that no group was received of; missing groups outside of it are lost. A hole counts as hidden
/// until a group inside it is received, and then as lost after all. A gap inside a packet is the hidden
/// sector, since loss affects complete packets. Without such a gap (VLS-128 with two returns) a sector is
/// hidden if nothing was received of it for ten turns.
///
/// Angles are integer hundredths of a degree with exact sums. The work of one call is bounded for all input.
class HiddenSectors {
 public:
  /// Adds a hole. Returns the number of packets found to be lost since the last call.
  std::uint64_t hole(const StreamHole& hole);
  /// Adds a packet. Returns the number of packets found to be lost since the last call.
  std::uint64_t receive(const PacketAzimuths& azimuths);
  /// End of the stream: an uncertain sector counts as loss if its hole did not recur, if chance can explain
  /// the holes, or if a wider sector is hidden.
  std::uint64_t finish();
  void reset() { *this = HiddenSectors(); }

 private:
  /// From the last group before to the first group after the sector.
  struct Sector {
    Hundredths from = 0, width = 0;
  };
  /// Disjoint sectors of 10 deg and more.
  using Sectors = boost::container::static_vector<Sector, 36>;
  /// A hole with groups in unseen sectors, which may be lost or hidden.
  struct PendingHole {
    StreamHole hole;
    std::int64_t counted;  // packets of it that count as lost
  };

  static bool exclude(Hundredths azimuth, Sectors& sectors);
  void learn(const Sector& gap);
  void count_turn(Hundredths azimuth);
  void count_again();
  void settle();
  bool could_be_chance(const Sector& sector, std::int64_t holes) const;
  std::int64_t hidden_groups(const StreamHole& hole) const;
  std::uint64_t new_losses() { return lost_ - std::exchange(reported_, lost_); }

  Sectors unseen_, recent_;  // nothing was received of them: since the stream began, in these ten turns
  bool certain_ = false;     // unseen_ is hidden: shown by a packet or by ten turns
  boost::container::static_vector<PendingHole, 64> pending_;
  int turns_ = 0;
  Hundredths last_ = 0, packet_ = 1;  // azimuth and angle of the last packet
  std::uint64_t received_ = 0, lost_ = 0, reported_ = 0;
};

}  // namespace lidard::velodyne
