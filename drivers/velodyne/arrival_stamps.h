// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "drivers/velodyne/azimuth.h"
#include "drivers/velodyne/model_row.h"
#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {

/// Stamps for packets that come without (HDL-64E S1): it numbers them, and a packet's number times the packet
/// period, as the arrivals have it, is its stamp, as if the sensor had a clock that was set to 0 with the
/// first packet.
///
/// How many packets lie between two, the azimuth tells but for whole turns, and the arrival tells those. A
/// packet that came late gets the number of its place, one that came twice the same number again. Where the
/// azimuth makes no sense (the head was stopped, the packets are of two sensors), the arrivals alone count.
/// Arrivals jitter by a fifth of a period and more; that is left to the clock that maps the stamps to the
/// host's time.
class ArrivalStamps {
 public:
  explicit ArrivalStamps(const ModelRow& row);

  /// Writes the stamp of its first firing into a packet, where others have theirs.
  void stamp(Stamp arrival, const PacketAzimuths& azimuths, std::uint8_t* packet);
  /// The next packet is the first.
  void reset();

 private:
  /// Of the packets so far, the newest counting most.
  struct Mean {
    double sum = 0, packets = 0;
    double value() const { return sum / packets; }
    void add(double amount, double count, double window);
  };
  double packets_since(Stamp arrival, double azimuth_deg) const;
  bool is_repeated(const std::uint8_t* packet) const;
  void advance(Span elapsed, double turned_deg, double packets);
  void learn(Span elapsed, double turned_deg, double packets);

  Span usual_period_;
  Mean period_ns_, turn_deg_;
  bool started_ = false;
  Stamp last_arrival_;
  double last_azimuth_deg_ = 0;
  std::array<std::uint8_t, stamp_offset> last_{};  // blocks of the last packet
  double time_ns_ = 0;
  double lag_ns_ = 0;  // of the stamps behind the arrivals, since the first packet
};

}  // namespace lidard::velodyne
