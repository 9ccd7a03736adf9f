// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "core/base/counters.h"
#include "core/base/time.h"
#include "drivers/velodyne/hidden_sector.h"
#include "drivers/velodyne/models.h"
#include "drivers/velodyne/packet.h"
#include "drivers/velodyne/timing.h"

namespace lidard::velodyne {

/// A data packet with its index in the stream.
struct OrderedPacket {
  std::array<std::uint8_t, packet_size> bytes;
  Stamp arrival;
  std::uint32_t index;  ///< number of earlier data packets of this sensor
  bool other_product;   ///< the product byte is not the model's
  const PacketLayout* layout;
  PacketAzimuths azimuths;
  Span time;         ///< device time, unwrapped; set by PacketStream, as the next member
  bool begins_anew;  ///< the device's clock was set, or packets were missing for seconds

  DataPacket view() const { return DataPacket(ByteView(bytes.data(), bytes.size())); }
};

/// Sorts packets by their stamps and measures what their firing times depend on: timing variant and rotation.
///
/// A packet is held back for one packet only after a gap in the stamps, or if only the next packet shows its
/// firing times, so that undisturbed packets are not delayed. The packet period also shows whether packets
/// with another product byte belong to the configured model.
class PacketStream {
 public:
  PacketStream(const ModelRow& row, Counters& counters)
      : row_(row), counters_(counters), timing_(&row.timings.front()), chooser_(row) {}

  /// Adds a packet of the right size and calls `use(packet, next)` for the packets that are due, in order;
  /// `next` only for a packet that has waited for the next one. Returns why this packet, or the one held back
  /// before it, was rejected (already counted).
  template <typename Use>
  Reject add(OrderedPacket& packet, Use&& use) {
    if (packet.other_product) {
      const Reject verdict = judge_product(packet);
      if (verdict != Reject::none) return verdict;
      // Held back until the next packet shows the period.
      if (packet.view().product() != wrong_product_) return Reject::none;
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
    // A larger step is not a late packet: the device's clock was set.
    constexpr Span step_limit = std::chrono::seconds(1);
    const Span step = since_last(packet);
    // A clock may also be set forward: the packet that follows in azimuth and in arrival is far ahead in
    // time.
    const bool gap = (step - due()) * 2 > last_period_;
    const bool set_forward = gap && (packet.arrival - last_arrival_) * 2 < step && continues(packet);
    if (step > -step_limit && step <= Span(0) && !is_clock_set(packet)) {
      const Reject reason = step == Span(0) ? Reject::duplicate : Reject::stale;
      if (reason == Reject::stale) ++counters_.reordered;
      counters_.reject(reason);
      return reason;
    }
    late_in_row_ = 0;
    if (step <= Span(0) || set_forward || step > 10 * step_limit) {
      ++counters_.clock_steps;
      started_ = false;
      advance(packet, use);
    } else if (gap) {
      held_ = packet;
      holding_ = true;
    } else {
      advance(packet, use);
    }
    return Reject::none;
  }

  /// End of the stream: the packet that is held back is due.
  template <typename Use>
  void flush(Use&& use) {
    if (is_product_undecided() && counters_.rejected[static_cast<std::size_t>(Reject::model)] > 0) {
      counters_.reject(Reject::model);
    } else if (holding_) {
      advance(held_, use);
    }
    holding_ = false;
    release(std::nullopt, use);
    count_early_holes();
    counters_.lost_packets += hidden_.finish();
  }
  void reset() {
    started_ = holding_ = passed_ = false;
    waiting_.reset();
    rotation_.forget_sector();
    hidden_.reset();
    early_count_ = 0;
  }
  /// That of the packet that `use` gets.
  const Timing& timing() const { return *timing_; }
  /// From sequence to sequence, where pauses are random.
  Span measured_sequence() const { return chooser_.measured_sequence(); }
  /// The rotation at a packet, for the duration of a hidden sector inside it; deg/s, 0 unknown.
  double turn_rate(const OrderedPacket& packet) {
    return rotation_.rate_at(packet.azimuths, packet.time, chooser_.timing().sequence,
                             row_.sequences_per_block());
  }
  /// Number of overflows of the stamps' hour.
  std::uint64_t wraps() const { return wraps_; }

 private:
  Span period(const OrderedPacket& p) const { return row_.packet_period(*timing_, p.layout->echoes); }
  /// The rotation, deg/s; 0 unknown.
  double rate() const {
    if (rotation_.rate() > 0 || last_azimuths_.groups == 0) return rotation_.rate();
    const Span group = last_period_ / static_cast<int>(last_azimuths_.groups);
    return plausible_rate(last_azimuths_.step_deg / seconds(group));
  }

  /// Time from the last packet to the next one if none is lost.
  Span due() const {
    if (last_azimuths_.hidden_total_deg <= 0 || rate() <= 0) return last_period_;
    // The packet is completed after the hidden sector, so its successor is late by the time of the sector.
    return last_period_ + span_from_seconds(last_azimuths_.hidden_total_deg / rate());
  }

  struct Hole {
    StreamHole hole;
    Span step;
    std::size_t echoes;
  };

  void count_loss(const OrderedPacket& packet, Span step) {
    if (step * 2 <= last_period_ * 3) return;
    Hole hole{};
    hole.step = step;
    hole.echoes = packet.layout->echoes;
    hole.hole.from = last_azimuths_.group[0];
    hole.hole.per_packet = static_cast<std::int64_t>(last_azimuths_.groups);
    // The azimuths give the angle modulo a turn, the rotation gives the number of turns.
    constexpr Hundredths jitter = 100;
    const Hundredths beyond = packet.azimuths.group[0] - hole.hole.from;
    const std::int64_t turns = std::llround((rate() * seconds(step) * 100 - beyond) / whole_turn);
    hole.hole.turned = beyond + whole_turn * std::max<std::int64_t>(turns, beyond < -jitter ? 1 : 0);
    if (!chooser_.decided() && early_count_ < early_.size()) {
      early_[early_count_++] = hole;
    } else {
      count_hole(hole);
    }
  }

  void count_hole(const Hole& hole) {
    StreamHole counted = hole.hole;
    const Span expected = row_.packet_period(*timing_, hole.echoes);
    counted.groups = std::max<std::int64_t>(
        1, std::llround(seconds(hole.step) / seconds(expected) * static_cast<double>(counted.per_packet)));
    counters_.lost_packets += hidden_.hole(counted);
  }

  void count_early_holes() {
    for (std::size_t i = 0; i < early_count_; ++i) count_hole(early_[i]);
    early_count_ = 0;
  }

  void remember(const OrderedPacket& packet) {
    last_period_ = period(packet);
    last_azimuths_ = packet.azimuths;
    counters_.lost_packets += hidden_.receive(last_azimuths_);
  }

  /// The arrivals show the full hours of a pause, which stamps within the hour do not.
  Span since_last(const OrderedPacket& p) const {
    constexpr Span hour = std::chrono::hours(1);
    const Span step = hour_difference(p.view().stamp_us(), last_us_);
    const bool is_next = step > Span(0) && (step - due()) * 2 <= last_period_;
    const auto hours = std::llround(seconds(p.arrival - last_arrival_ - step) / seconds(hour));
    return is_next || hours <= 0 ? step : Span(step + hour * hours);
  }
  /// The held packet has another product byte; the next packet's period decides whether the byte is wrong.
  bool is_product_undecided() const {
    return holding_ && held_.other_product && held_.view().product() != wrong_product_;
  }
  /// For a stamp that does not advance: true if the sensor's clock was set, since the packet has the azimuth
  /// of the next one, or many such packets follow.
  bool is_clock_set(const OrderedPacket& packet) {
    // A late packet or a duplicate has an azimuth that was received before.
    constexpr std::size_t most_late = 16;
    return continues(packet) || ++late_in_row_ > most_late;
  }
  /// True if the packet has the azimuth of the one after the last.
  bool continues(const OrderedPacket& packet) const {
    constexpr double slowest_deg = 0.02;  // per packet
    const double turn = last_azimuths_.step_deg * static_cast<double>(last_azimuths_.groups);
    const double turned = std::remainder(packet.view().azimuth(0) * 0.01 - last_azimuths_.group_deg(0), 360);
    return turn > slowest_deg && std::abs(turned - turn) * 2 < turn;
  }

  /// True if the period belongs to the configured model, whatever the product byte says: not if the model of
  /// that byte has another period, which explains it as well (663.6 us of a VLP-32C are half of a VLP-16's).
  bool is_model_period(Span step, const OrderedPacket& packet) const {
    const std::size_t echoes = packet.layout->echoes;
    constexpr int most_lost = 2;  // packets between the two
    for (const ModelRow* other : model_rows()) {
      const Span its = other->packet_period(other->timings.front(), echoes);
      if (other->has_product(packet.view().product()) && !is_period_of(row_, its, echoes, 0) &&
          is_period_of(*other, step, echoes, most_lost))
        return false;
    }
    return is_period_of(row_, step, echoes, most_lost);
  }
  static bool is_period_of(const ModelRow& row, Span step, std::size_t echoes, int most_lost) {
    for (const Timing& timing : row.timings) {
      const Span expected = row.packet_period(timing, echoes);
      // Clocks and random pauses stay within 3 %.
      for (int n = 1; n <= 1 + most_lost; ++n) {
        const Span off = step - expected * n;
        if (off < expected * 3 / 100 && off > -expected * 3 / 100) return true;
      }
    }
    return false;
  }

  Reject judge_product(const OrderedPacket& packet) {
    const std::uint8_t product = packet.view().product();
    if (product == wrong_product_) return Reject::none;
    if (is_product_undecided()) {
      const Span step = hour_difference(packet.view().stamp_us(), held_.view().stamp_us());
      if (step == Span(0)) {
        counters_.reject(Reject::duplicate);
        return Reject::duplicate;
      }
      if (is_model_period(step < Span(0) ? -step : step, packet)) {
        wrong_product_ = product;
        return Reject::none;
      }
      counters_.reject(Reject::model);  // for the held packet
      held_ = packet;
      return Reject::model;
    } else if (started_) {
      if (is_model_period(since_last(packet), packet)) {
        wrong_product_ = product;
        return Reject::none;
      }
      counters_.reject(Reject::model);
      return Reject::model;
    }
    held_ = packet;
    holding_ = true;
    return Reject::none;
  }

  template <typename Use>
  void advance(OrderedPacket& packet, Use&& use) {
    // Times within a frame are differences, so a jump of the device's clock ends the frame.
    constexpr Span jump = std::chrono::seconds(5);
    const std::uint32_t us = packet.view().stamp_us();
    Span step{0};
    if (!started_) {
      packet.time = std::chrono::microseconds(us);
      packet.begins_anew = passed_;
    } else {
      step = since_last(packet);
      packet.time = time_ + step;
      if (us < last_us_ && step > Span(0)) ++wraps_;
      count_loss(packet, step);
      packet.begins_anew = step < Span(0) || step > jump;
    }
    started_ = true;
    time_ = packet.time;
    last_us_ = us;
    last_arrival_ = packet.arrival;
    remember(packet);
    if (packet.other_product) ++counters_.wrong_product;
    pass_on(packet, step, use);
  }

  /// Passes a packet on, `step` after the one before; it waits if only the next one shows its firing times.
  template <typename Use>
  void pass_on(const OrderedPacket& packet, Span step, Use&& use) {
    if (packet.begins_anew) {
      release(std::nullopt, use);
      rotation_.restart();
    }
    rotation_.add(packet.view().azimuth(0) * 0.01, step);
    if (passed_ && !packet.begins_anew) {
      chooser_.add(step, row_.sequences_per_packet(last_echoes_));
      release(NextPacket{step}, use);
    }
    passed_ = true;
    last_echoes_ = packet.layout->echoes;
    if (row_.random_rest || packet.azimuths.hidden_total_deg > 0 || !chooser_.decided())
      waiting_ = packet;
    else
      give(packet, std::nullopt, use);
  }

  template <typename Use>
  void release(const std::optional<NextPacket>& next, Use&& use) {
    if (!waiting_) return;
    give(*waiting_, next, use);
    waiting_.reset();
  }

  template <typename Use>
  void give(const OrderedPacket& packet, const std::optional<NextPacket>& next, Use&& use) {
    const bool is_old = row_.without_factory_bytes != nullptr && !row_.has_product(packet.view().product());
    timing_ = is_old ? row_.without_factory_bytes : &chooser_.timing();
    if (chooser_.decided()) count_early_holes();
    use(packet, next);
  }

  const ModelRow& row_;
  Counters& counters_;
  bool started_ = false;
  bool holding_ = false;
  OrderedPacket held_{};
  std::uint32_t last_us_ = 0;
  Stamp last_arrival_{};
  std::uint64_t wraps_ = 0;
  Span last_period_{0};
  PacketAzimuths last_azimuths_;
  std::size_t late_in_row_ = 0;
  const Timing* timing_;
  TimingChooser chooser_;
  Rotation rotation_;
  HiddenSector hidden_;
  std::array<Hole, 16> early_{};  // before the timing variant, which gives their packets, was known
  std::size_t early_count_ = 0;
  Span time_{0};                               // of the last packet
  std::size_t last_echoes_ = 1;                // of the last packet
  bool passed_ = false;                        // a packet was passed on, or waits
  std::optional<OrderedPacket> waiting_;       // until the next packet shows its times
  std::optional<std::uint8_t> wrong_product_;  // of packets that are of the model although they name this one
};

}  // namespace lidard::velodyne
