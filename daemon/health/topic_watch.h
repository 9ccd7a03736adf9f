// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/time.h"

namespace lidard {

/// Rate, regularity and latency of a topic.
struct TopicFigures {
  std::uint64_t frames = 0;              ///< since the start
  std::uint64_t dropped = 0;             ///< of these, dropped because publishing was too slow
  std::uint64_t lost = 0;                ///< messages lost by a slow subscriber
  bool loses = false;                    ///< messages were lost within the last 10 s
  double rate_hz = 0;                    ///< in the last 10 s; 0: less than two frames
  Span shortest_gap{0}, longest_gap{0};  ///< between two frames of the last 10 s
  /// From the arrival of the packet that completed a frame to the publication of the frame, over the last 512
  /// frames.
  Span median_latency{0}, p99_latency{0}, longest_latency{0};
};

/// Computes the figures of one topic. Does not allocate.
class TopicWatch {
 public:
  void released(Stamp at) {
    ++frames_;
    releases_.add(at);
  }
  /// If the host's clock was set and nobody has noticed yet, the frame does not count.
  void published(Span latency) {
    constexpr Span longest_way = std::chrono::minutes(1);
    if (latency >= Span(0) && latency < longest_way) latencies_.add(latency);
  }

  /// The newest release; 1970: none.
  Stamp newest() const { return releases_.count > 0 ? releases_.back(0) : Stamp(); }
  TopicFigures figures(Stamp now) const {
    TopicFigures out;
    out.frames = frames_;
    add_gaps(now, out);
    const std::size_t count = latencies_.count;
    if (count == 0) return out;
    auto sorted = latencies_.values;
    std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count));
    out.median_latency = sorted[count / 2];
    out.p99_latency = sorted[count * 99 / 100];
    out.longest_latency = sorted[count - 1];
    return out;
  }

 private:
  template <class Value>
  struct Ring {
    static constexpr std::size_t length = 512;
    std::array<Value, length> values{};
    std::size_t next = 0, count = 0;
    void add(Value value) {
      values[next] = value;
      next = (next + 1) % length;
      count = std::min(count + 1, length);
    }
    /// The i-th newest value.
    Value back(std::size_t i) const { return values[(next + length - 1 - i) % length]; }
  };

  void add_gaps(Stamp now, TopicFigures& out) const {
    constexpr Span window = std::chrono::seconds(10);
    std::size_t gaps = 0;
    for (std::size_t i = 0; i + 1 < releases_.count && now - releases_.back(i + 1) <= window; ++i) {
      const Span gap = releases_.back(i) - releases_.back(i + 1);
      out.shortest_gap = gaps == 0 ? gap : std::min(out.shortest_gap, gap);
      out.longest_gap = std::max(out.longest_gap, gap);
      ++gaps;
    }
    if (gaps == 0) return;
    const double s = seconds(releases_.back(0) - releases_.back(gaps));
    if (s > 0) out.rate_hz = static_cast<double>(gaps) / s;
  }

  std::uint64_t frames_ = 0;
  Ring<Stamp> releases_;
  Ring<Span> latencies_;
};

}  // namespace lidard
