// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "drivers/velodyne/packet_stream.h"

namespace lidard::velodyne {

/// Distinguishes the packets of two sensors with one address: stamps or azimuths jump to another stream and
/// back, and both streams go on without a gap. Packets that come late, twice or over several lines stay with
/// their stream, and a sensor that starts again never goes on with the former one.
class TwoStreams {
 public:
  /// True if the packet goes on with another stream than the first packet. `period`: from packet to packet.
  bool is_other(const OrderedPacket& packet, Span period) {
    const Firing firing{packet.view().stamp_us(), packet.azimuths.group_deg(0)};
    if (!goes_on(firing, last_, period)) {
      is_other_ = is_other_ != goes_on(firing, former_, period);
      former_ = last_;
    }
    last_ = firing;
    return is_other_;
  }

 private:
  /// The first one of a packet.
  struct Firing {
    std::uint32_t us;
    double azimuth_deg;
  };
  /// The two clocks may be the same (PPS), and both rotors have about one rate: that from a packet to the
  /// next one, some percent of it are rounding.
  bool goes_on(const Firing& firing, const Firing& before, Span period) {
    constexpr Span longest = std::chrono::milliseconds(100);
    constexpr double fastest = 7200;  // deg/s: 1200 rpm
    const double passed_s = seconds(hour_difference(firing.us, before.us)), most_s = 2 * seconds(period);
    const double turned_deg = std::remainder(firing.azimuth_deg - before.azimuth_deg, 360);
    const bool is_next = passed_s > 0 && passed_s < most_s;
    const double off_deg = std::remainder(turned_deg - rate_ * passed_s, 360);
    const double slack_deg = std::max(0.5, rate_ * seconds(period)) + 0.1 * rate_ * std::abs(passed_s);
    const bool does = rate_ > 0 ? std::abs(passed_s) < seconds(longest) && std::abs(off_deg) < slack_deg
                                : is_next && turned_deg >= 0 && turned_deg <= fastest * passed_s;
    if (does && is_next) rate_ = turned_deg / passed_s;
    return does;
  }

  Firing last_{}, former_{};  // of the newest packet, and of the newest one before the last jump
  double rate_ = 0;           // deg/s; 0: not known
  bool is_other_ = false;
};

}  // namespace lidard::velodyne
