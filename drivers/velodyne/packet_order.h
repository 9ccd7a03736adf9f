// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/base/counters.h"
#include "core/base/time.h"
#include "drivers/velodyne/hidden_sectors.h"
#include "drivers/velodyne/models.h"
#include "drivers/velodyne/packet.h"

namespace lidard::velodyne {

/// A data packet with its place in the stream.
struct OrderedPacket {
  std::array<std::uint8_t, packet_size> bytes;
  Stamp arrival;
  std::uint32_t index;  ///< data packets of this sensor before it
  bool other_product;   ///< its product byte is not the model's
  const PacketLayout* layout;
  PacketAzimuths azimuths;

  DataPacket view() const { return DataPacket(ByteView(bytes.data(), bytes.size())); }
};

/// Brings packets into the order of their stamps, looking one packet ahead only where the stamps leave a
/// hole, so that undisturbed packets are not delayed. Also decides whether packets with another product byte
/// are those of the configured model: a product byte can lie, the packet period cannot.
class PacketOrder {
 public:
  PacketOrder(const ModelRow& row, Counters& counters)
      : row_(row), counters_(counters), timing_(&row.timings.front()), decided_(row.timings.size() == 1) {}

  /// Takes a packet of the right size and calls `use(packet, device_time)` for each that is due, in order;
  /// device time is unwrapped. Returns why this packet was not used, if so; the counters hold it already.
  template <typename Use>
  Reject add(const OrderedPacket& packet, Use&& use);
  /// No packet follows: what is held back is due.
  template <typename Use>
  void flush(Use&& use) {
    if (is_held_in_doubt() && counters_.rejected[static_cast<std::size_t>(Reject::model)] > 0) {
      counters_.reject(Reject::model);
    } else if (holding_) {
      advance(held_, use);
    }
    holding_ = false;
    count_early_holes();
    counters_.lost_packets += hidden_.finish();
  }
  void reset() {
    started_ = holding_ = false;
    hidden_.reset();
    early_count_ = 0;
  }
  /// The timing variant in force; `decided`: chosen by the packets, not the usual one for want of a better.
  void set_timing(const Timing& timing, bool decided);
  /// Measured rotation, deg/s, a plausible one; 0 unknown.
  void set_turn_rate(double deg_per_s) { turn_rate_ = deg_per_s; }
  /// Azimuth in the middle of the sector that the sensor leaves out; empty: none, or not known yet.
  std::optional<double> hidden_middle_deg() const { return hidden_.middle_deg(); }
  /// The product byte that contradicts the model although the packets are the model's, if any.
  std::optional<std::uint8_t> lying_product() const { return lying_product_; }
  /// The product byte of packets refused as another model's, if any.
  std::optional<std::uint8_t> refused_product() const { return refused_product_; }

 private:
  Span period(const OrderedPacket& p) const { return row_.packet_period(*timing_, p.layout->echoes); }
  /// Rotation as far as it is known, deg/s; 0 unknown.
  double rate() const;
  /// Time from the last packet to the next one if none is lost.
  Span due() const;
  struct Hole {
    StreamHole hole;
    Span step;
    std::size_t echoes;
  };
  void count_loss(const OrderedPacket& packet, Span step);
  void count_hole(const Hole& hole);
  void count_early_holes();
  void remember(const OrderedPacket& packet);
  Span since_last(const OrderedPacket& p) const { return hour_difference(p.view().stamp_us(), last_us_); }
  /// The held packet has another product byte, and the next packet's period is to tell whether it lies.
  bool is_held_in_doubt() const {
    return holding_ && held_.other_product && held_.view().product() != lying_product_;
  }
  /// The stamp of a packet goes back or stays: true if the sensor's clock was set, for the packet has the
  /// azimuth of the next one, or many such follow each other.
  bool is_clock_set(const OrderedPacket& packet);
  bool is_model_period(Span step, const OrderedPacket& packet) const;
  Reject judge_product(const OrderedPacket& packet);
  template <typename Use>
  void advance(const OrderedPacket& packet, Use&& use);

  const ModelRow& row_;
  Counters& counters_;
  bool started_ = false;
  bool holding_ = false;
  OrderedPacket held_{};
  std::uint32_t last_us_ = 0;
  Span last_period_{0};
  PacketAzimuths last_azimuths_;
  std::size_t late_in_row_ = 0;
  const Timing* timing_;
  bool decided_;
  HiddenSectors hidden_;
  std::array<Hole, 16> early_{};  // seen before the timing variant was known, which tells their packets
  std::size_t early_count_ = 0;
  double turn_rate_ = 0;
  Span time_{0};
  std::optional<std::uint8_t> lying_product_;
  std::optional<std::uint8_t> refused_product_;
};

template <typename Use>
void PacketOrder::advance(const OrderedPacket& packet, Use&& use) {
  const std::uint32_t us = packet.view().stamp_us();
  if (!started_) {
    time_ = std::chrono::microseconds(us);
  } else {
    const Span step = since_last(packet);
    time_ += step;
    count_loss(packet, step);
  }
  started_ = true;
  last_us_ = us;
  remember(packet);
  if (packet.other_product) ++counters_.lying_packets;
  use(packet, time_);
}

template <typename Use>
Reject PacketOrder::add(const OrderedPacket& packet, Use&& use) {
  if (packet.other_product) {
    const Reject verdict = judge_product(packet);
    if (verdict != Reject::none) return verdict;
    // Held back until the next one tells the period.
    if (packet.view().product() != lying_product_) return Reject::none;
  }
  if (holding_) {
    const Span after_held = hour_difference(packet.view().stamp_us(), held_.view().stamp_us());
    if (after_held == Span(0)) {
      counters_.reject(Reject::duplicate);
      return Reject::duplicate;
    }
    holding_ = false;
    const bool between = after_held < Span(0) && (!started_ || since_last(packet) > Span(0));
    if (between) {
      ++counters_.reordered;
      advance(packet, use);
      advance(held_, use);
      return Reject::none;
    }
    advance(held_, use);
  }
  if (!started_) {
    advance(packet, use);
    return Reject::none;
  }
  // So far back or ahead it is no late packet: the device's clock was set.
  constexpr Span step_limit = std::chrono::seconds(1);
  const Span step = since_last(packet);
  if (step > -step_limit && step <= Span(0) && !is_clock_set(packet)) {
    const Reject reason = step == Span(0) ? Reject::duplicate : Reject::stale;
    if (reason == Reject::stale) ++counters_.reordered;
    counters_.reject(reason);
    return reason;
  }
  late_in_row_ = 0;
  if (step <= Span(0) || step > 10 * step_limit) {
    ++counters_.clock_steps;
    started_ = false;
    advance(packet, use);
  } else if ((step - due()) * 2 > last_period_) {
    held_ = packet;
    holding_ = true;
  } else {
    advance(packet, use);
  }
  return Reject::none;
}

}  // namespace lidard::velodyne
