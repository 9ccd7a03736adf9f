// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bitset>
#include <boost/container/static_vector.hpp>
#include <cstddef>
#include <cstdint>

#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {

/// The gap between two packets that are not consecutive.
struct StreamHole {
  Hundredths from;      ///< first group of the packet before
  std::int64_t turned;  ///< 1/100 deg, from the first group before to the first group after, with full turns
  std::int64_t groups;  ///< firing groups in that time, sent, hidden or lost: at least 1
  std::int64_t per_packet;  ///< groups of a packet: at least 1
};

/// Distinguishes lost packets from the sector that a limited field of view hides.
///
/// The stamps show how many firing groups passed between two packets, and the azimuth shows which of them
/// were in the hidden sector; the others are lost. A sensor hides one sector at most. A packet with a gap
/// inside shows the sector, since loss affects complete packets. Without such packets (VLS-128 with two
/// returns) a sector is hidden if nothing was received of it for ten turns. Until then, wide holes over a
/// sector that nothing was received of wait; those over other sectors are lost.
class HiddenSector {
 public:
  /// Adds a hole. Returns the number of packets found to be lost.
  std::uint64_t hole(const StreamHole& hole);
  /// Adds a packet. Returns the number of packets found to be lost in former holes.
  std::uint64_t receive(const PacketAzimuths& azimuths);
  /// End of the stream: the holes that wait are lost, unless they recurred over one sector that is too wide
  /// for chance.
  std::uint64_t finish();
  void reset() { *this = HiddenSector(); }

 private:
  /// From the last group before to the first group after it.
  struct Sector {
    Hundredths from = 0, width = 0;  // width 0: none
  };

  Sector widest_unseen() const;
  Sector widest_unseen(const Sector& arc, Hundredths least) const;
  std::uint64_t end_turn();
  std::uint64_t settle(const Sector& hidden);
  static std::int64_t groups_inside(const StreamHole& hole, const Sector& sector);
  static std::uint64_t lost_of(const StreamHole& hole, const Sector& hidden);

  std::bitset<static_cast<std::size_t>(whole_turn)> seen_;  // azimuths of the groups in these ten turns
  Sector hidden_;
  bool is_known_ = false;  // hidden_
  boost::container::static_vector<StreamHole, 64> waiting_;
  int turns_ = 0;
  Hundredths last_ = 0, packet_ = 1;  // azimuth and angle of the last packet
};

}  // namespace lidard::velodyne
