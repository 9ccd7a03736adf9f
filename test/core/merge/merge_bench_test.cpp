// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The figures that bench/report_merge prints for many scenes, here for few, so that they cannot get worse
// unseen.
#include <gtest/gtest.h>

#include "test/support/merge_score.h"

namespace lidard::sim {
namespace {

struct MergeTotals {
  MergeScore strict, safety, ancestor;
  std::uint64_t dropped = 0;
};

MergeTotals totals_of(const MergeCase& set_up, std::uint64_t scenes) {
  MergeTotals totals;
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) {
    const MergeScene scene = make_scene(set_up, seed);
    const TruthfulClaims ours = truthful_claims(scene, set_up);
    totals.strict.add(judge(scene, set_up, ours.strict));
    totals.safety.add(judge(scene, set_up, ours.safety));
    totals.ancestor.add(judge(scene, set_up, ancestor_claims(scene)));
    totals.dropped += ours.dropped;
  }
  return totals;
}

TEST(MergeBench, StrictIsRightAndNeverFalselyFreeAtHalfADegree) {
  const MergeCase& set_up = merge_cases()[1];
  const MergeTotals totals = totals_of(set_up, 12);
  const MergeScore& s = totals.strict;
  ASSERT_GT(s.seen, 10'000U);
  EXPECT_GE(s.share(s.right), 97.5);
  EXPECT_LE(s.share(s.see_through), 0.3);
  EXPECT_EQ(s.false_free, 0U);
  EXPECT_EQ(s.unseen_free, 0U);
  EXPECT_LE(s.unseen_share(s.unseen_wrong + s.unseen_free), 2);
  EXPECT_LE(s.rms(), set_up.noise);
  EXPECT_LT(totals.ancestor.share(totals.ancestor.right), 85);
}

// Of thousands of returns; their surfaces are seen from the other side alone.
constexpr std::uint64_t few_seen_from_behind = 2;

TEST(MergeBench, SafetyDropsNoReturnThatCanBeSeenAndIsNeverFalselyFree) {
  for (const MergeCase& set_up : merge_cases()) {
    const MergeTotals totals = totals_of(set_up, 4);
    EXPECT_EQ(totals.safety.false_free, 0U) << set_up.name;
    EXPECT_EQ(totals.safety.unseen_free, 0U) << set_up.name;
    EXPECT_LE(totals.dropped, few_seen_from_behind) << set_up.name;
  }
}

TEST(MergeBench, CoarserOutputThanInputKeepsItsAccuracy) {
  const MergeTotals totals = totals_of(merge_cases()[3], 12);
  const MergeScore& s = totals.strict;
  EXPECT_GE(s.share(s.right), 98);
  EXPECT_EQ(s.false_free, 0U);
}

TEST(MergeBench, SparseScannersFillADenseOutput) {
  const MergeTotals totals = totals_of(merge_cases()[4], 12);
  const MergeScore& s = totals.strict;
  // Beside each edge the way between two beams, a degree, is unknown.
  EXPECT_GE(s.share(s.right), 94.4);
  EXPECT_LE(s.share(s.see_through), 0.3);
  EXPECT_EQ(s.false_free, 0U);
  EXPECT_LT(totals.ancestor.share(totals.ancestor.right), 40);
}

TEST(MergeBench, DrivingMakesNoClaimWrong) {
  const MergeCase& set_up = merge_cases()[5];
  const MergeTotals totals = totals_of(set_up, 12);
  const MergeScore& s = totals.strict;
  ASSERT_GT(s.seen, 10'000U);
  EXPECT_GE(s.share(s.right), 97);
  EXPECT_LE(s.share(s.see_through), 0.3);
  EXPECT_LE(s.unseen_share(s.unseen_wrong), 2);
  EXPECT_LE(s.rms(), set_up.noise);
  for (const MergeScore* score : {&totals.strict, &totals.safety}) {
    EXPECT_EQ(score->false_free, 0U);
    EXPECT_EQ(score->unseen_free, 0U);
  }
  EXPECT_LE(totals.dropped, few_seen_from_behind);
}

}  // namespace
}  // namespace lidard::sim
