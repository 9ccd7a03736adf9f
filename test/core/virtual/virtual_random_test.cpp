// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "test/support/random_cloud.h"

namespace lidard {
namespace {

TEST(Virtualizer, KeepsItsInvariantsWhateverCloudsComeIn) {
  std::size_t scans = 0;
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    std::vector<std::uint8_t> bytes(20000);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    scans += sim::virtualize_bytes(bytes.data(), bytes.size());
  }
  EXPECT_GT(scans, 1000U);
}

}  // namespace
}  // namespace lidard
