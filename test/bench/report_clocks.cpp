// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Simulated devices of every family on a virtual clock: how far their stamps are from the truth. Prints one
// table; arguments: seconds of each run (default 40), runs of each (default 4), part of a family's name.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "test/support/clock_bench.h"
#include "test/support/clock_scenarios.h"

int main(int argc, char** argv) {
  using namespace lidard;
  using namespace lidard::test;
  const Span length = std::chrono::seconds(argc > 1 ? std::atoi(argv[1]) : 40);
  const auto runs = static_cast<std::uint64_t>(argc > 2 ? std::atoi(argv[2]) : 4);
  const char* only = argc > 3 ? argv[3] : "";
  std::printf("ms from the truth                            from 2 s on               | before 2 s   |\n");
  std::printf("%-44s %6s %6s %6s %6s | %6s %6s | frames missing backwards jumps steps\n", "", "rms", "p99",
              "worst", "mean", "<0.5 s", "<2 s");
  for (const BenchFamily& family : bench_families()) {
    if (std::strstr(family.name, only) == nullptr) continue;
    std::printf("%s\n", family.name);
    for (const BenchScenario& scenario : clock_scenarios()) {
      BenchFigures all;
      for (std::uint64_t seed = 1; seed <= runs; ++seed) {
        const BenchFigures one = run_clock_bench(family, scenario, length, seed);
        all.rms = std::max(all.rms, one.rms), all.p99 = std::max(all.p99, one.p99);
        all.worst = std::max(all.worst, one.worst), all.first = std::max(all.first, one.first);
        if (std::abs(one.mean) > std::abs(all.mean)) all.mean = one.mean;
        all.start = std::max(all.start, one.start);
        all.frames += one.frames, all.missing += one.missing, all.backwards += one.backwards;
        all.jumps += one.jumps, all.steps += one.steps;
      }
      std::printf("  %-42s %6.3f %6.3f %6.3f %+6.3f | %6.3f %6.3f | %6zu %7zu %9zu %5zu %5llu\n",
                  scenario.name, all.rms * 1e3, all.p99 * 1e3, all.worst * 1e3, all.mean * 1e3,
                  all.first * 1e3, all.start * 1e3, all.frames, all.missing, all.backwards, all.jumps,
                  static_cast<unsigned long long>(all.steps));
    }
  }
  return 0;
}
