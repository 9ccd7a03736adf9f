// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/health/topic_health.h"

#include <fmt/format.h>

#include "daemon/health/sentences.h"

namespace lidard {
namespace {

std::string ms(Span span) { return fmt::format("{:.1f}", 1e3 * seconds(span)); }

}  // namespace

DiagnosticItem topic_health(const std::string& topic, const TopicFigures& f) {
  DiagnosticItem item{"topic " + topic};
  f.loses ? item.set<says::slow_subscriber>(topic) : item.set<says::publishing>();
  item.values = {{"Messages/s", fmt::format("{:.1f}", f.rate_hz)},
                 {"Shortest gap of the last 10 s (ms)", ms(f.shortest_gap)},
                 {"Longest gap of the last 10 s (ms)", ms(f.longest_gap)},
                 {"Latency, median (ms)", ms(f.median_latency)},
                 {"Latency, 99 of 100 (ms)", ms(f.p99_latency)},
                 {"Latency, longest (ms)", ms(f.longest_latency)}};
  item.add("Dropped before ROS", f.dropped);
  item.add("Lost by slow subscribers", f.lost);
  return item;
}

}  // namespace lidard
