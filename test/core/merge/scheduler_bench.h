// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include "core/merge/scheduler.h"
#include "test/sim/world/rng.h"
#include "test/sim/world/units.h"

namespace lidard::test {

constexpr Stamp origin{1'700'000'000'000'000'000};

/// A scanner that runs freely; all in ms.
struct FreeScanner {
  double period, phase;
  double silent_from = 1e9, back = 1e9;
  double delay = 0, delay_jitter = 0;  ///< from the last ray to the arrival
  double jitter = 0;                   ///< of the last ray's stamp, +-
  double late_at = -1, late_by = 0;    ///< one sweep that arrives late
};

/// What a scheduler makes of scanners until `to` ms, asked at deliveries, when it says, and (`always`) every
/// half millisecond too.
class Schedule {
 public:
  struct Output {
    Span at;
    std::vector<char> use;
    std::vector<double> ends;  ///< ms, of the newest sweeps
    double skew() const {
      double first = 1e9, last = -1e9;
      for (std::size_t s = 0; s < use.size(); ++s)
        if (use[s] != 0) first = std::min(first, ends[s]), last = std::max(last, ends[s]);
      return last - first;
    }
  };

  Schedule(const std::vector<FreeScanner>& scanners, double to, const ScheduleSettings& settings = {},
           bool always = false)
      : scheduler(scanners.size(), settings), newest_(scanners.size(), 0) {
    add_sweeps(scanners, to);
    Span now{};
    for (auto next = sweeps_.begin(); now < ms(to);) {
      if (scheduler.is_due(origin + now)) {
        outputs.push_back({now, scheduler.usable(origin + now), newest_});
        scheduler.done(origin + now);
      }
      const Span delivery = ms(next->arrival);
      Span at = delivery;
      if (const auto event = scheduler.next_event()) at = std::min(at, *event - origin);
      if (always) at = std::min(at, now + ms(0.5));
      now = at;
      if (now != delivery || now >= ms(to)) continue;
      newest_[next->source] = next->end;
      scheduler.delivered(next->source, origin + ms(next->end), scanners[next->source].period / 1000,
                          origin + now);
      ++next;
    }
  }

  /// Forgets the outputs before `from` ms.
  Schedule& skip_to(double from) {
    outputs.erase(outputs.begin(), std::find_if(outputs.begin(), outputs.end(),
                                                [&](const Output& output) { return output.at >= ms(from); }));
    return *this;
  }
  /// Hz.
  double rate() const {
    if (outputs.size() < 2) return 0;
    return static_cast<double>(outputs.size() - 1) / seconds(outputs.back().at - outputs.front().at);
  }
  double worst_skew() const {
    double worst = 0;
    for (const Output& output : outputs) worst = std::max(worst, output.skew());
    return worst;
  }
  std::vector<double> gaps_ms() const {
    std::vector<double> all;
    for (std::size_t i = 1; i < outputs.size(); ++i)
      all.push_back(1000 * seconds(outputs[i].at - outputs[i - 1].at));
    return all;
  }
  double longest_gap() const {
    const std::vector<double> gaps = gaps_ms();
    return gaps.empty() ? 1e9 : *std::max_element(gaps.begin(), gaps.end());
  }

  Scheduler scheduler;
  std::vector<Output> outputs;

 private:
  struct Sweep {
    double arrival, end;
    std::size_t source;
  };

  void add_sweeps(const std::vector<FreeScanner>& scanners, double to) {
    sim::Rng rng(7);
    for (std::size_t s = 0; s < scanners.size(); ++s) {
      const FreeScanner& c = scanners[s];
      for (double due = c.phase; due < to + 1000; due += c.period) {
        const double end = due + c.jitter * (2 * rng.uniform() - 1);
        const double late = due <= c.late_at && c.late_at < due + c.period ? c.late_by : 0;
        const double arrival = end + c.delay + c.delay_jitter * rng.uniform() + late;
        if (arrival < c.silent_from || arrival >= c.back) sweeps_.push_back({arrival, end, s});
      }
    }
    std::stable_sort(sweeps_.begin(), sweeps_.end(), [](auto& a, auto& b) { return a.arrival < b.arrival; });
    sweeps_.push_back({2 * to, 2 * to, 0});  // whoever is silent, time goes on
  }

  std::vector<Sweep> sweeps_;
  std::vector<double> newest_;
};

}  // namespace lidard::test
