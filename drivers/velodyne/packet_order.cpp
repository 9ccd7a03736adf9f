// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/packet_order.h"

#include <algorithm>
#include <cmath>

namespace lidard::velodyne {

bool PacketOrder::is_model_period(Span step, const OrderedPacket& packet) const {
  const std::size_t echoes = packet.layout->echoes;
  for (const Timing& timing : row_.timings) {
    const Span expected = row_.packet_period(timing, echoes);
    // A lost packet or two may lie between; clocks and random rests stay well within 3 %.
    for (int n = 1; n <= 3; ++n) {
      const Span off = step - expected * n;
      if (off < expected * 3 / 100 && off > -expected * 3 / 100) return true;
    }
  }
  return false;
}

bool PacketOrder::is_clock_set(const OrderedPacket& packet) {
  // A packet that was late or came twice looks where others looked before.
  constexpr std::size_t most_late = 16;
  constexpr double slowest_deg = 0.02;  // per packet
  const double turn = last_azimuths_.step_deg * static_cast<double>(last_azimuths_.groups);
  const double turned = std::remainder(packet.view().azimuth(0) * 0.01 - last_azimuths_.group_deg(0), 360);
  const bool continues = turn > slowest_deg && std::abs(turned - turn) * 2 < turn;
  return continues || ++late_in_row_ > most_late;
}

double PacketOrder::rate() const {
  if (turn_rate_ > 0 || last_azimuths_.groups == 0) return turn_rate_;
  const Span group = last_period_ / static_cast<int>(last_azimuths_.groups);
  return plausible_rate(last_azimuths_.step_deg / seconds(group));
}

Span PacketOrder::due() const {
  if (last_azimuths_.hidden_total_deg <= 0 || rate() <= 0) return last_period_;
  // The packet goes on to be filled after the hidden sector, so its successor comes later by the time of the
  // silence.
  return last_period_ + span_from_seconds(last_azimuths_.hidden_total_deg / rate());
}

void PacketOrder::count_loss(const OrderedPacket& packet, Span step) {
  if (step * 2 <= last_period_ * 3) return;
  Hole hole{};
  hole.step = step;
  hole.echoes = packet.layout->echoes;
  hole.hole.from = last_azimuths_.group[0];
  hole.hole.last = last_azimuths_.group[last_azimuths_.groups - 1];
  hole.hole.per_packet = static_cast<std::int64_t>(last_azimuths_.groups);
  // The azimuths tell the turn up to whole ones, the rotation tells how many those are.
  constexpr Hundredths jitter = 100;
  const Hundredths beyond = packet.azimuths.group[0] - hole.hole.from;
  const std::int64_t turns = std::llround((rate() * seconds(step) * 100 - beyond) / whole_turn);
  hole.hole.turned = beyond + whole_turn * std::max<std::int64_t>(turns, beyond < -jitter ? 1 : 0);
  if (!decided_ && early_count_ < early_.size()) {
    early_[early_count_++] = hole;
  } else {
    count_hole(hole);
  }
}

void PacketOrder::count_hole(const Hole& hole) {
  StreamHole counted = hole.hole;
  const Span expected = row_.packet_period(*timing_, hole.echoes);
  counted.groups = std::max<std::int64_t>(
      1, std::llround(seconds(hole.step) / seconds(expected) * static_cast<double>(counted.per_packet)));
  counters_.lost_packets += hidden_.hole(counted);
}

void PacketOrder::count_early_holes() {
  for (std::size_t i = 0; i < early_count_; ++i) count_hole(early_[i]);
  early_count_ = 0;
}

void PacketOrder::set_timing(const Timing& timing, bool decided) {
  timing_ = &timing;
  decided_ = decided;
  if (decided) count_early_holes();
}

void PacketOrder::remember(const OrderedPacket& packet) {
  last_period_ = period(packet);
  last_azimuths_ = packet.azimuths;
  counters_.lost_packets += hidden_.receive(last_azimuths_);
}

Reject PacketOrder::judge_product(const OrderedPacket& packet) {
  const std::uint8_t product = packet.view().product();
  if (product == lying_product_) return Reject::none;
  if (is_held_in_doubt()) {
    const Span step = hour_difference(packet.view().stamp_us(), held_.view().stamp_us());
    if (step == Span(0)) {
      counters_.reject(Reject::duplicate);
      return Reject::duplicate;
    }
    if (is_model_period(step < Span(0) ? -step : step, packet)) {
      lying_product_ = product;
      return Reject::none;
    }
    counters_.reject(Reject::model);  // for the held one, whose verdict came late
    refused_product_ = held_.view().product();
  } else if (started_) {
    if (is_model_period(since_last(packet), packet)) {
      lying_product_ = product;
      return Reject::none;
    }
    refused_product_ = product;
    counters_.reject(Reject::model);
    return Reject::model;
  }
  held_ = packet;
  holding_ = true;
  return Reject::none;
}

}  // namespace lidard::velodyne
