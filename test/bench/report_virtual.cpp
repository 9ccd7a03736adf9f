// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Virtual scans of random yards by the ways of other tools and by our cut, judged against the truth.
// Prints one table; arguments: yards per set-up (default 100), first seed (default 1).
#include <cstdio>
#include <cstdlib>
#include <limits>

#include "test/support/yard.h"

namespace lidard::sim {
namespace {

void print(const char* method, const YardScore& s) {
  const auto hidden = static_cast<double>(s.beams - s.visible);
  std::printf("  %-22s %6.2f %8.2f %7.2f | %8.2f %7.3f %7.2f | %8.2f | %7.2f\n", method, s.share(s.right),
              s.share(s.phantom), s.missed(), s.share(s.through), s.share(s.free), s.share(s.silent),
              s.share_missed_of_sampled(),
              hidden > 0 ? 100.0 * static_cast<double>(s.hidden_wrong) / hidden : 0.0);
}

void report(const YardCase& set_up, int yards, std::uint64_t first_seed) {
  const std::pair<const char*, double> bands[] = {{"no z test", std::numeric_limits<double>::infinity()},
                                                  {"slab of 1 cm", 0.01},
                                                  {"band +-0.1 m", 0.1},
                                                  {"band +-0.3 m", 0.3}};
  YardScore others[4], strict, safety;
  for (int i = 0; i < yards; ++i) {
    const YardScene scene = make_yard_scene(set_up, first_seed + static_cast<std::uint64_t>(i));
    for (int k = 0; k < 4; ++k) others[k].add(judge_yard(scene, banded_claims(scene, bands[k].second)));
    strict.add(judge_yard(scene, cut_claims(scene, Profile::strict)));
    safety.add(judge_yard(scene, cut_claims(scene, Profile::safety)));
  }
  std::printf("%s; %d yards, the lidar could see the true hit of %.1f %% of the beams\n", set_up.name, yards,
              100.0 * static_cast<double>(strict.visible) / static_cast<double>(strict.beams));
  for (int k = 0; k < 4; ++k) print(bands[k].first, others[k]);
  print("cut, strict", strict);
  print("cut, safety", safety);
}

}  // namespace
}  // namespace lidard::sim

int main(int argc, char** argv) {
  const int yards = argc > 1 ? std::atoi(argv[1]) : 100;
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
  std::printf("  %% of the beams whose true hit the lidar could see: missed = through + free + silent\n");
  std::printf("  %-22s %6s %8s %7s | %8s %7s %7s | %8s | %7s\n", "method", "right", "phantom", "missed",
              "through", "free", "silent", "missed**", "hidden*");
  for (const auto& set_up : lidard::sim::yard_cases()) lidard::sim::report(set_up, yards, seed);
  std::printf("  * %% of the other beams about which something wrong is said\n");
  std::printf("  ** of the beams whose true hit a beam of the lidar meets above the plane too\n");
  return 0;
}
