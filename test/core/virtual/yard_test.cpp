// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/yard.h"

#include <gtest/gtest.h>

#include <string>

namespace lidard {
namespace {

struct Bar {
  const char* name;
  std::size_t which;
  double strict_right, safety_right;
};

class YardBars : public ::testing::TestWithParam<Bar> {};

TEST_P(YardBars, MostOfWhatTheLidarCouldSeeIsRightAndNothingIsFalselyFree) {
  const sim::YardCase& set_up = sim::yard_cases()[GetParam().which];
  sim::YardScore strict, safety, band;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const sim::YardScene scene = sim::make_yard_scene(set_up, seed);
    strict.add(sim::judge_yard(scene, sim::cut_claims(scene, Profile::strict)));
    safety.add(sim::judge_yard(scene, sim::cut_claims(scene, Profile::safety)));
    band.add(sim::judge_yard(scene, sim::banded_claims(scene, 0.3)));
  }
  EXPECT_GT(strict.visible, strict.beams * 9 / 10);
  EXPECT_GE(strict.share(strict.right), GetParam().strict_right);
  EXPECT_GE(safety.share(safety.right), GetParam().safety_right);
  EXPECT_GT(safety.right, band.right);
  // Shortly behind a return safety ends a beam where no source sees: the thing may be that thick. A level top
  // that noise does not distinguish from a square face counts as a face.
  EXPECT_LE(safety.share(safety.phantom), 1.2);
  EXPECT_LE(safety.share_missed_of_sampled(), 1.5);
  EXPECT_EQ(strict.free + safety.free, 0U);
}

INSTANTIATE_TEST_SUITE_P(PlaneAtHalfAMetre, YardBars,
                         ::testing::Values(Bar{"of_16_rings", 0, 97, 98}, Bar{"of_32_rings", 3, 97.2, 98.5},
                                           Bar{"of_64_rings", 5, 98, 99.1}),
                         [](const auto& each) { return std::string(each.param.name); });

TEST(Virtualizer, GroundThatIsFoundServesAsWellAsOneThatIsConfigured) {
  for (const auto& set_up : sim::yard_cases()) {
    if (std::string(set_up.name).find("plane at 0.5 m") == std::string::npos) continue;
    sim::YardScore configured, found;
    for (std::uint64_t seed = 1; seed <= 4; ++seed) {
      const sim::YardScene scene = sim::make_yard_scene(set_up, seed);
      configured.add(sim::judge_yard(scene, sim::cut_claims(scene, Profile::safety, GroundModel::plane)));
      found.add(sim::judge_yard(scene, sim::cut_claims(scene, Profile::safety, GroundModel::slope)));
    }
    EXPECT_GE(found.share(found.right), configured.share(configured.right) - 1.0) << set_up.name;
  }
}

}  // namespace
}  // namespace lidard
