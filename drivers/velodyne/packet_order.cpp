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

bool PacketOrder::is_model_period(Span step, Span expected) const {
  // A lost packet or two may lie between; motors and clocks stay well within 3 %.
  for (int n = 1; n <= 3; ++n) {
    const Span off = step - expected * n;
    if (off < expected * 3 / 100 && off > -expected * 3 / 100) return true;
  }
  return false;
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
    if (is_model_period(step < Span(0) ? -step : step, period(packet))) {
      lying_product_ = product;
      return Reject::none;
    }
    counters_.reject(Reject::model);  // for the held one, whose verdict came late
    refused_product_ = held_.view().product();
  } else if (started_) {
    if (is_model_period(since_last(packet), last_period_)) {
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
