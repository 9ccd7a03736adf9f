// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Open yards with things made to be missed; bench/report_hidden prints the same figures for many of them.
#include <gtest/gtest.h>

#include <cctype>
#include <string>

#include "test/support/hidden.h"

namespace lidard::sim {
namespace {

struct Totals {
  HidingScore strict, safety;
};

Totals totals_of(const HidingCase& set_up, std::uint64_t first, std::uint64_t yards) {
  Totals totals;
  for (std::uint64_t seed = first; seed < first + yards; ++seed) {
    const HidingScene scene = make_hiding_scene(set_up, seed);
    totals.strict.add(judge_hiding(set_up, scene, scene.strict));
    totals.safety.add(judge_hiding(set_up, scene, scene.safety));
  }
  return totals;
}

class HiddenThings : public ::testing::TestWithParam<std::size_t> {};

TEST_P(HiddenThings, AreNeitherFalselyFreeNorSeenThrough) {
  const HidingCase& set_up = hiding_cases()[GetParam()];
  const Totals totals = totals_of(set_up, 1, set_up.from_cloud ? 12 : 24);
  ASSERT_GT(totals.strict.blocked, 300U);
  // Of a cloud the edge of a thing is known to a column of cells, and a corner may pass between two.
  // A wall that one ring meets may look like the top of a lower thing.
  const std::uint64_t share = set_up.hiding == Hiding::low_walls ? 200 : 500;
  const std::uint64_t most = set_up.from_cloud ? totals.strict.blocked / share : 0;
  EXPECT_LE(totals.strict.falsely_free, most);
  EXPECT_LE(totals.safety.falsely_free, most);
  EXPECT_LE(totals.strict.seen_through, totals.strict.blocked / share);
  if (set_up.hiding == Hiding::posts) {
    EXPECT_LE(totals.safety.seen_through, totals.safety.blocked / 100);
  }
  if (set_up.hiding == Hiding::posts && !set_up.from_cloud) {
    EXPECT_EQ(totals.safety.seen_through, 0U);
    EXPECT_GE(totals.strict.right * 100, totals.strict.blocked * 92);
    EXPECT_GE(totals.strict.open_free * 100, totals.strict.open * 97);
  }
}

INSTANTIATE_TEST_SUITE_P(Yards, HiddenThings, ::testing::Range<std::size_t>(0, hiding_cases().size()),
                         [](const auto& each) {
                           std::string name;
                           for (const char c : std::string(hiding_cases()[each.param].name))
                             if (std::isalnum(static_cast<unsigned char>(c)) != 0) name += c;
                           return name;
                         });

}  // namespace
}  // namespace lidard::sim
