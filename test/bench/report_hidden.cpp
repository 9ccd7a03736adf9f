// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Open yards with things made to be missed, merged and virtualized, judged against the truth.
// Prints one table; arguments: yards per set-up (default 300), first seed (default 1).
#include <cstdio>
#include <cstdlib>

#include "test/support/hidden.h"

namespace lidard::sim {
namespace {

void print(const char* profile, const HidingScore& s) {
  const auto share = [](std::uint64_t count, std::uint64_t of) {
    return of == 0 ? 0 : 100 * static_cast<double>(count) / static_cast<double>(of);
  };
  std::printf("  %-7s %8llu %6.2f %8llu %8llu %8.2f %8.2f | %6.2f %6.3f\n", profile,
              static_cast<unsigned long long>(s.blocked), share(s.right, s.blocked),
              static_cast<unsigned long long>(s.falsely_free),
              static_cast<unsigned long long>(s.seen_through), share(s.phantom, s.blocked),
              share(s.unknown, s.blocked), share(s.open_free, s.open), share(s.open_hit, s.open));
}

}  // namespace
}  // namespace lidard::sim

int main(int argc, char** argv) {
  using namespace lidard::sim;
  const int yards = argc > 1 ? std::atoi(argv[1]) : 300;
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
  std::printf("  %-7s %8s %6s %8s %8s %8s %8s | %% of open beams\n", "", "blocked", "right %", "f-free",
              "through", "phantom%", "unknown%");
  for (const HidingCase& set_up : hiding_cases()) {
    HidingScore strict, safety;
    for (int i = 0; i < yards; ++i) {
      const HidingScene scene = make_hiding_scene(set_up, seed + static_cast<std::uint64_t>(i));
      strict.add(judge_hiding(set_up, scene, scene.strict));
      safety.add(judge_hiding(set_up, scene, scene.safety));
    }
    std::printf("%s; %d yards\n", set_up.name, yards);
    print("strict", strict);
    print("safety", safety);
  }
  return 0;
}
