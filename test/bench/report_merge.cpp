// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Random scenes merged by the ancestor's formula, by rounding, and by our profiles, judged against the truth.
// Prints one table; arguments: scenes per set-up (default 300), first seed (default 1).
#include <cstdio>
#include <cstdlib>
#include <functional>

#include "test/support/merge_score.h"

namespace lidard::sim {
namespace {

void print(const char* method, const MergeScore& s) {
  std::printf("  %-16s %6.2f %8.2f %8.2f %8.3f %7.2f | %7.2f %7.2f | %6.1f %6.1f %6.2f\n", method,
              s.share(s.right), s.share(s.see_through), s.share(s.phantom), s.share(s.false_free),
              s.share(s.silent), s.unseen_share(s.unseen_free), s.unseen_share(s.unseen_wrong),
              s.rms() * 1000, s.p99() * 1000, s.bias() * 1000);
}

void report(const MergeCase& set_up, int scenes, std::uint64_t first_seed) {
  MergeScore ancestor, rounding, strict, safety;
  std::uint64_t dropped = 0, returns = 0;
  for (int i = 0; i < scenes; ++i) {
    const MergeScene scene = make_scene(set_up, first_seed + static_cast<std::uint64_t>(i));
    ancestor.add(judge(scene, set_up, ancestor_claims(scene)));
    rounding.add(judge(scene, set_up, rounding_claims(scene)));
    const TruthfulClaims ours = truthful_claims(scene, set_up);
    strict.add(judge(scene, set_up, ours.strict));
    safety.add(judge(scene, set_up, ours.safety));
    dropped += ours.dropped;
    returns += ours.returns;
  }
  std::printf("%s; %d scenes, %.1f %% of the beams observable\n", set_up.name, scenes,
              100.0 * static_cast<double>(strict.seen) / static_cast<double>(strict.seen + strict.unseen));
  print("ira formula", ancestor);
  print("rounding", rounding);
  print("strict", strict);
  print("safety", safety);
  std::printf("  safety has nothing at or before %llu of %llu returns\n",
              static_cast<unsigned long long>(dropped), static_cast<unsigned long long>(returns));
}

}  // namespace
}  // namespace lidard::sim

int main(int argc, char** argv) {
  const int scenes = argc > 1 ? std::atoi(argv[1]) : 300;
  const auto seed = static_cast<std::uint64_t>(argc > 2 ? std::atoll(argv[2]) : 1);
  std::printf(
      "  %% of observable beams:                                  | %% of the others  | right hits, mm\n");
  std::printf("  %-16s %6s %8s %8s %8s %7s | %7s %7s | %6s %6s %6s\n", "method", "right", "through",
              "phantom", "f-free", "silent", "f-free", "wrong", "rms", "p99", "bias");
  for (const auto& set_up : lidard::sim::merge_cases()) lidard::sim::report(set_up, scenes, seed);
  return 0;
}
