// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "drivers/velodyne/models.h"
#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {

/// What the packet after one tells about it.
struct NextPacket {
  Span step;  ///< from stamp to stamp
};

/// When each group of a packet's blocks fired, and how fast the sensor turned meanwhile.
struct FiringSchedule {
  std::array<Span, blocks_per_packet> begin{};  ///< first firing of each group after the packet's stamp
  Span sequence{0};                             ///< from one firing sequence to the next
  Span end{0};                                  ///< of the packet's last sequence after the stamp
  double rate_deg_per_s = 0;
};

/// The schedule of a packet, by the timing in force and, where sequences rest for a random time, by the
/// sequences that were measured. Needs the next packet where sequences rest for a random time or where a
/// hidden sector lies inside the packet: the groups after it fired late, by the time of the silence. Without
/// it, `turn_rate` (deg/s of whole revolutions, 0 unknown) places them; a packet's own azimuth steps are too
/// coarse for that.
FiringSchedule schedule_of(const ModelRow& row, const Timing& timing, Span measured_sequence,
                           const PacketAzimuths& azimuths, std::size_t echoes,
                           const std::optional<NextPacket>& next, double turn_rate);

/// Chooses a model's timing variant by the median packet period, which no configuration knows and which the
/// random rest of a VLS-128 blurs: a single pair of packets would often mislead.
class TimingChooser {
 public:
  explicit TimingChooser(const ModelRow& row) : row_(row), chosen_(&row.timings.front()) {}

  /// Two consecutive packets without loss or hidden sector between them: the time from one to the other.
  void add(Span step, std::size_t sequences);
  const Timing& timing() const { return *chosen_; }
  /// False until there is something to choose by.
  bool decided() const { return row_.timings.size() == 1 || count_ > 0; }
  /// Mean time from sequence to sequence as measured; the chosen variant's before.
  Span measured_sequence() const;

 private:
  const ModelRow& row_;
  const Timing* chosen_;
  std::array<std::int64_t, 64> steps_{};   // ns per sequence, in order of arrival
  std::array<std::int64_t, 64> sorted_{};  // the same in order of size
  std::size_t count_ = 0;
  std::int64_t sum_ = 0;
};

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
