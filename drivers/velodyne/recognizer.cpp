// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/recognizer.h"

#include <algorithm>

#include "drivers/velodyne/packet.h"
#include "drivers/velodyne/packet_layout.h"
#include "drivers/velodyne/packet_order.h"

namespace lidard::velodyne {
namespace {

/// A row of the family whose flags the packet has; nullptr if it is no data packet.
const ModelRow* family_of(ByteView payload) {
  if (payload.size() != packet_size) return nullptr;
  const DataPacket packet(payload);
  for (const ModelRow* row : model_rows()) {
    if (check_blocks(packet, layout_of(packet, *row)) == Reject::none) return row;
  }
  return nullptr;
}

bool within_percent(Span a, Span b, int percent) {
  return a * 100 < b * (100 + percent) && a * 100 > b * (100 - percent);
}

}  // namespace

void Recognizer::add(ByteView payload) {
  const ModelRow* family = family_of(payload);
  if (family == nullptr) return;
  const DataPacket packet(payload);
  if (packets_ > 0 && step_count_ < steps_.size()) {
    const Span step = hour_difference(packet.stamp_us(), last_us_);
    if (step != Span(0)) steps_[step_count_++] = step < Span(0) ? -step.count() : step.count();
  }
  last_us_ = packet.stamp_us();
  ++packets_;
  banks_ = family->banks;
  if (layout_of(packet, *family).echoes == 2) ++dual_packets_;
  product_ = packet.product();
}

Span Recognizer::median_period() const {
  constexpr std::size_t enough = 3;
  if (step_count_ < enough) return Span(0);
  auto sorted = steps_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(step_count_ / 2);
  std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(step_count_));
  return Span(*middle);
}

const ModelRow* Recognizer::by_product() const {
  for (const ModelRow* row : model_rows()) {
    if (row->banks == banks_ && row->has_product(product_)) return row;
  }
  return nullptr;
}

const ModelRow* Recognizer::verdict() const {
  if (packets_ == 0) return nullptr;
  const Span period = median_period();
  const std::size_t echoes = dual_packets_ * 2 > packets_ ? 2 : 1;
  const auto fits = [&](const ModelRow* row) {
    for (const Timing& timing : row->timings) {
      if (row->banks == banks_ && within_percent(period, row->packet_period(timing, echoes), 3)) return true;
    }
    return false;
  };
  const ModelRow* named = by_product();
  if (period == Span(0) || (named != nullptr && fits(named))) return named;
  for (const ModelRow* row : model_rows()) {
    if (fits(row)) return row;
  }
  return nullptr;
}

std::string Recognizer::remark() const {
  if (packets_ == 0) return {};
  const ModelRow* row = verdict();
  if (row == nullptr) return "Velodyne packets of a " + product_name(product_) + ", which is not supported";
  if (!row->names_product() || row->has_product(product_)) return {};
  return "product byte says " + product_name(product_) + ", the packet period says " +
         std::string(row->product);
}

}  // namespace lidard::velodyne
