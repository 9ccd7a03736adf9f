// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "test/support/clock_bench.h"

namespace lidard::test {

/// What happens to devices on the bench: drift, jitter, overflows, reboots, a host's clock that is set.
inline const std::vector<BenchScenario>& clock_scenarios() {
  using namespace std::chrono_literals;
  static const std::vector<BenchScenario> scenarios = [] {
    std::vector<BenchScenario> all;
    const auto add = [&all](const char* name, double ppm, Span jitter, double outliers) -> BenchScenario& {
      BenchScenario scenario;
      scenario.name = name;
      scenario.ppm = ppm;
      scenario.jitter = jitter;
      scenario.outliers = outliers;
      return all.emplace_back(scenario);
    };
    add("quiet network", 0, 20us, 0);
    add("fast by 200 ppm, 0.3 ms jitter", 200, 300us, 0);
    add("slow by 200 ppm, 5 ms jitter, outliers", -200, 5ms, 0.01);
    add("fast by 200 ppm, 5 ms jitter, outliers", 200, 5ms, 0.01);
    add("counter overflows after 9 s", 100, 300us, 0.01).wrap = 9s;
    add("rebooted after 15 s", 100, 300us, 0.01).reboot = 15s;
    for (const auto& [name, step] : {std::pair("host set by +1 s", 1.0),
                                     {"host set by -1 s", -1.0},
                                     {"host set by +1e8 s", 1e8},
                                     {"host set by -1e8 s", -1e8}}) {
      BenchScenario& scenario = add(name, 100, 300us, 0.01);
      scenario.step_at = 12s;
      scenario.step_s = step;
    }
    add("host slewed by +500 ppm for 10 s", 100, 300us, 0.01).slew_ppm = 500;
    add("host slewed by -500 ppm for 10 s", 100, 300us, 0.01).slew_ppm = -500;
    BenchScenario& recorded = add("a capture whose stamps jump by -3600 s", 100, 300us, 0.01);
    recorded.step_at = 12s;
    recorded.step_s = -3600;
    recorded.recorded = true;
    return all;
  }();
  return scenarios;
}

}  // namespace lidard::test
