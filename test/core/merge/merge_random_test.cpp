// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "test/support/random_merge.h"

namespace lidard {
namespace {

TEST(Merge, KeepsItsInvariantsWhateverSweepsComeIn) {
  std::size_t outputs = 0;
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    std::vector<std::uint8_t> bytes(12000);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    outputs += sim::merge_bytes(bytes.data(), bytes.size());
  }
  EXPECT_GT(outputs, 150U);
}

}  // namespace
}  // namespace lidard
