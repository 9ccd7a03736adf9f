// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/packet_order.h"

#include <cstdlib>

namespace lidard::velodyne {

Span hour_difference(std::uint32_t later_us, std::uint32_t earlier_us) {
  constexpr std::int64_t hour_us = 3'600'000'000;
  std::int64_t difference =
      (static_cast<std::int64_t>(later_us) - static_cast<std::int64_t>(earlier_us)) % hour_us;
  if (difference > hour_us / 2) difference -= hour_us;
  if (difference < -hour_us / 2) difference += hour_us;
  return std::chrono::microseconds(difference);
}

bool PacketOrder::is_model_period(Span step, const OrderedPacket& packet) const {
  const std::size_t echoes = layout_of(packet.view(), row_).echoes;
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

Span PacketOrder::due() const {
  if (last_azimuths_.hidden_total_deg <= 0) return last_period_;
  // The packet goes on to be filled after the hidden sector, so its successor comes later by the time of the
  // silence.
  if (turn_rate_ <= 0) return std::chrono::seconds(2);
  return last_period_ + span_from_seconds(last_azimuths_.hidden_total_deg / turn_rate_);
}

void PacketOrder::count_loss(const OrderedPacket& packet, Span step) {
  const Span excess = step - due();
  if (excess * 2 <= last_period_) return;
  const auto packets = static_cast<std::uint64_t>((excess + last_period_ / 2) / last_period_);
  const double from = last_azimuths_.group_deg[last_azimuths_.groups - 1];
  const double to = packet.view().azimuth(0) * 0.01;
  counters_.lost_packets += hidden_.hole(from, to, packets, turned_deg_ + turn_rate_ * seconds(step));
}

void PacketOrder::remember(const OrderedPacket& packet) {
  last_period_ = period(packet);
  last_azimuths_ = read_azimuths(packet.view(), layout_of(packet.view(), row_));
  turned_deg_ = turn_rate_ * seconds(time_);
  for (std::size_t g = 1; g < last_azimuths_.groups; ++g) {
    if (last_azimuths_.hidden_deg[g] > 0)
      hidden_.learn(last_azimuths_.group_deg[g - 1], last_azimuths_.group_deg[g]);
  }
}

Reject PacketOrder::judge_product(const OrderedPacket& packet) {
  const std::uint8_t product = packet.view().product();
  if (product == lying_product_) return Reject::none;
  if (holding_ && held_.other_product) {
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
