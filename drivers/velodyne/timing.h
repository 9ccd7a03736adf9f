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

/// Data from the following packet.
struct NextPacket {
  Span step;  ///< from stamp to stamp
};

/// Firing times of the groups of a packet's blocks, and the rotation.
struct FiringSchedule {
  std::array<Span, blocks_per_packet> begin{};  ///< first firing of each group after the packet's stamp
  Span sequence{0};                             ///< from one firing sequence to the next
  Span end{0};                                  ///< of the packet's last sequence after the stamp
  double rate_deg_per_s = 0;
};

/// The schedule of a packet from the timing variant and, for random pauses, from the measured sequences. It
/// needs the next packet for random pauses and for a hidden sector inside the packet, after which groups
/// fired late. Without the next packet, `turn_rate` (deg/s of full revolutions, 0 unknown) gives their times;
/// the azimuth steps of one packet are too coarse.
FiringSchedule schedule_of(const ModelRow& row, const Timing& timing, Span measured_sequence,
                           const PacketAzimuths& azimuths, std::size_t echoes,
                           const std::optional<NextPacket>& next, double turn_rate);

/// Chooses a model's timing variant by the median packet period; the random pause of a VLS-128 makes single
/// periods unreliable.
class TimingChooser {
 public:
  explicit TimingChooser(const ModelRow& row) : row_(row), chosen_(&row.timings.front()) {}

  /// Adds the time between two packets without loss or hidden sector between them.
  void add(Span step, std::size_t sequences);
  const Timing& timing() const { return *chosen_; }
  /// False before the first period.
  bool decided() const { return row_.timings.size() == 1 || count_ > 0; }
  /// Measured mean time from sequence to sequence; before, that of the chosen variant.
  Span measured_sequence() const;

 private:
  const ModelRow& row_;
  const Timing* chosen_;
  std::array<std::int64_t, 64> steps_{};   // ns per sequence, in order of arrival
  std::array<std::int64_t, 64> sorted_{};  // sorted copy
  std::size_t count_ = 0;
  std::int64_t sum_ = 0;
};

/// Measures the rotation from the azimuths of packets.
class Rotation {
 public:
  /// Adds a packet by the azimuth of its first block, `step` after the packet before; 0: none before.
  void add(double azimuth_deg, Span step);
  /// Over the last packets, deg/s, a plausible one; 0 unknown.
  double rate() const;
  /// The same for a packet at `time` with a hidden sector inside: over full turns, from one begin of the
  /// sector to the next. `sequence`: from firing sequence to firing sequence, `per_block` of them in a block.
  double rate_at(const PacketAzimuths& azimuths, Span time, Span sequence, std::size_t per_block);
  /// The next hidden sector is the first one.
  void forget_sector() { edge_.reset(); }
  /// Restarts with the next packet.
  void restart() { *this = Rotation(); }

 private:
  /// Where and when a hidden sector begins.
  struct Edge {
    Span time;
    double azimuth_deg;
  };
  double last_azimuth_deg_ = 0;
  double turned_deg_ = 0, turned_s_ = 0;
  std::optional<Edge> edge_;  // of the last hidden sector inside a packet
};

/// Stamps for packets without stamps (HDL-64E S1): a packet's number times the measured packet period, as
/// from a clock that starts with the first packet.
///
/// The azimuth gives the number of packets modulo a turn, and the arrival gives the turns. A late packet gets
/// the number that its azimuth shows, a duplicate the same number again. If the azimuth is implausible (the
/// head stopped, or packets of two sensors), only the arrivals count. Where the arrivals stand, apart from
/// whole seconds, the azimuths alone count packets of the period so far. The clock that maps the stamps to
/// the host's time smooths the jitter of arrivals.
class ArrivalStamps {
 public:
  explicit ArrivalStamps(const ModelRow& row);

  /// Writes the stamp of the first firing into a packet, where other models have it.
  void stamp(Stamp arrival, const PacketAzimuths& azimuths, std::uint8_t* packet);
  /// Restarts with the next packet.
  void reset();

 private:
  /// Mean with exponential weights.
  struct Mean {
    double sum = 0, packets = 0;
    double value() const { return sum / packets; }
    void add(double amount, double count, double window);
  };
  double packets_since(Span elapsed, double azimuth_deg) const;
  bool is_repeated(const std::uint8_t* packet) const;
  void advance(Span elapsed, double turned_deg, double packets);
  void learn(Span elapsed, double turned_deg, double packets);

  Span usual_period_;
  Mean period_ns_, turn_deg_;
  bool started_ = false;
  Stamp last_arrival_;
  std::size_t standing_ = 0;  // packets in a row whose arrivals stood
  double last_azimuth_deg_ = 0;
  std::array<std::uint8_t, stamp_offset> last_{};  // blocks of the last packet
  double time_ns_ = 0;
  double lag_ns_ = 0;  // lag of the stamps behind the arrivals, since the first packet
};

}  // namespace lidard::velodyne
