// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

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

/// Counts lost packets, but not what a sensor does not send because its field of view is limited.
///
/// The stamps say how many firing groups passed between two packets, the azimuths where these groups stood. A
/// group in a sector that packets came from is lost. A group in a sector that nothing came from is in doubt:
/// it is lost as soon as something comes from there, unless so many holes lay over the sector that it was the
/// field of view. A sector that is narrowed later shows inside a packet, since loss removes whole packets, or
/// by holes that recur at one azimuth.
class FieldOfView {
 public:
  FieldOfView();
  /// Packets found to be lost since the last call, in this hole or in earlier ones.
  std::uint64_t hole(const StreamHole& hole);
  /// A packet came. Returns how many earlier packets are found to be lost now.
  std::uint64_t receive(const PacketAzimuths& azimuths);
  /// No packet follows: what is in doubt is lost, unless holes lay over the same sector again.
  std::uint64_t finish();
  void reset() { *this = FieldOfView(); }

 private:
  struct Sector {
    Hundredths from = 0, width = 0;  // between the last group before and the first group after it
  };
  struct Doubt {
    StreamHole hole;
    std::int64_t counted;  // packets of it that count as lost
  };
  static bool overlap(const Sector& a, const Sector& b);
  static std::int64_t groups_inside(const StreamHole& hole, const Sector& sector);
  std::int64_t holes_over(const Sector& sector) const;
  void forget_holes_over(const Sector& sector);
  std::int64_t lost_of(const StreamHole& hole, std::int64_t& in_doubt) const;
  std::uint64_t count_again();
  void add(const Sector& sector);
  bool see(Hundredths from, Hundredths width);

  bool started_ = false;
  std::vector<Sector> unseen_;  // nothing came from them; none overlaps another
  std::vector<Doubt> doubts_;   // holes with groups in these sectors
  Sector known_;                // hidden by a field of view: it lay inside a packet
  Sector wide_;                 // the last hole that was wide enough for a field of view
  int times_ = 0;               // so often in succession at this place
};

}  // namespace lidard::velodyne
