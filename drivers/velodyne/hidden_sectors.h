// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace lidard::velodyne {

/// Tells a hole that packets left when they got lost from the sector a sensor hides because its field of view
/// is limited. A sector seen inside a packet is hidden for certain: loss takes whole packets. Where the
/// sector ends with a packet it looks like loss, but comes back at the same place every turn.
class HiddenSectors {
 public:
  /// A packet had this sector inside it. Angles in deg, as the sensor counts them.
  void learn(double from_deg, double to_deg);
  /// Between two packets there was this hole, `packets` wide. Returns how many packets are known to be lost
  /// now, from this or earlier holes: 0 while it may be a hidden sector.
  std::uint64_t hole(double from_deg, double to_deg, std::uint64_t packets, double turned_deg);
  /// No packet follows: what is still in doubt counts as lost unless it came twice.
  std::uint64_t finish();
  void reset() { *this = HiddenSectors(); }

 private:
  struct Sector {
    double from_deg = 0, to_deg = 0;
    std::uint64_t packets = 0;  // in doubt; all turns together
    int turns = 0;              // seen so far
    double last_turned_deg = 0;
    bool known = false;
    bool used = false;
  };
  Sector* find(double from_deg, double to_deg);

  std::array<Sector, 8> sectors_{};
};

}  // namespace lidard::velodyne
