// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/topic_clock.h"

#include <algorithm>

namespace lidard {
namespace {

/// Clocks that are kept by NTP in one network differ by less.
constexpr Span clocks_differ = std::chrono::milliseconds(20);
/// No message is on its way for longer.
constexpr Span longest_way = std::chrono::seconds(10);
/// A few stamps are wrong when the host's clock is set.
constexpr int many_strikes = 6, most_strikes = 20;

}  // namespace

Stamp TopicClock::correct(Stamp stamp, Span lasts, Stamp arrival) {
  const Span ahead = stamp + lasts - arrival;
  const bool is_foreign = ahead > lead_ + clocks_differ || ahead < -longest_way;
  strikes_ = std::clamp(strikes_ + (is_foreign ? 2 : -1), 0, most_strikes);
  if (!is_foreign) return std::min(stamp, arrival + lead_ - lasts);
  ++replaced_;
  ahead_ = ahead;
  if (stamp <= newest_) clock_.reset();
  newest_ = stamp;
  clock_.observe(Span(stamp.ns) + lasts, arrival);
  return std::min(clock_.to_host(Span(stamp.ns)), arrival - lasts);
}

std::optional<Span> TopicClock::ahead() const {
  return strikes_ < many_strikes ? std::nullopt : std::optional(ahead_);
}

}  // namespace lidard
