// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "drivers/velodyne/packet_order.h"

namespace lidard::velodyne {

/// Finds out that two sensors with one address send: stamps or azimuths jump to another stream and back, and
/// both streams go on without a gap. Neither packets that come late, twice or over several lines nor a sensor
/// that starts again or is exchanged do that.
class TwoDevices {
 public:
  /// Adds a packet in the order of arrival; `period`: from packet to packet.
  void add(const OrderedPacket& packet, Span period) {
    const Place place{packet.view().stamp_us(), packet.azimuths.group_deg(0),
                      packet.azimuths.step_deg * static_cast<double>(packet.azimuths.groups)};
    const std::uint32_t mark = place.us ^ static_cast<std::uint32_t>(packet.azimuths.group[0]) << 16U;
    // The packets of 65 ms are remembered, each in a slot of its own: no two lie within 4 us.
    const std::size_t slot = (place.us >> 2U) % seen_.size();
    if (std::exchange(seen_[slot], mark) == mark) return;  // a copy
    ++packets_;
    if (place.follows(last_, period)) {
      ++following_;
    } else {
      const bool is_back = place.follows(other_, period);
      other_ = last_;
      following_ += is_back ? 1 : 0;
      // A single late packet is a jump too, but follows nothing.
      returns_ += is_back && came_back_ ? 1 : 0;
      came_back_ = is_back;
    }
    last_ = place;
    if (packets_ == window) conclude(packet.arrival);
  }
  /// True if they were found in the last ten seconds.
  bool found(Stamp now) const { return found_ && std::chrono::abs(now - *found_) < memory; }

 private:
  static constexpr int window = 128, most_strays = window / 3, fewest_returns = window / 16;
  static constexpr Span memory = std::chrono::seconds(10);
  struct Place {
    std::uint32_t us;
    double azimuth_deg, turn_deg;  // of the first firing, and from packet to packet
    /// The two clocks may be the same (PPS), and both rotors have about one rate.
    bool follows(const Place& before, Span period) const {
      const double periods = seconds(hour_difference(us, before.us)) / seconds(period);
      const double off = std::remainder(azimuth_deg - before.azimuth_deg - periods * turn_deg, 360);
      return periods > 0.7 && periods < 1.3 && std::abs(off) < std::max(0.5, turn_deg);
    }
  };

  void conclude(Stamp now) {
    const bool takes_turns = packets_ - following_ <= most_strays && returns_ >= fewest_returns;
    packets_ = following_ = returns_ = 0;
    if (takes_turns) found_ = now;
  }

  Place last_{}, other_{};  // of the newest packet, and of the newest one before the last jump
  bool came_back_ = false;  // with the last jump
  int packets_ = 0, following_ = 0, returns_ = 0;
  std::array<std::uint32_t, 16384> seen_{};
  std::optional<Stamp> found_;  // the last time
};

}  // namespace lidard::velodyne
