// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/registry/nearest_models.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/model.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

using ::testing::Contains;
using ::testing::IsEmpty;

TEST(NearestModels, FindsTypingMistakesAndOtherSpellings) {
  for (const char* written :
       {"velodyne_vlp61", "velodyn_vlp16", "VLP-16", "vlp16", "Velodyne VLP 16", "vlp_16"}) {
    const auto names = nearest_models(written);
    ASSERT_FALSE(names.empty()) << written;
    EXPECT_EQ(names.front(), "velodyne_vlp16") << written;
  }
}

TEST(NearestModels, ABeginningFindsTheFamily) {
  EXPECT_THAT(nearest_models("velodyne"), Contains("velodyne_vlp16"));
}

TEST(NearestModels, AreAtMostThreeKnownNames) {
  for (const Model& model : models()) {
    const auto names = nearest_models(model.name);
    ASSERT_FALSE(names.empty());
    EXPECT_LE(names.size(), 3U);
    EXPECT_EQ(names.front(), model.name);
    for (const auto name : names) EXPECT_NE(find_model(name), nullptr);
  }
}

TEST(NearestModels, AreNoneForNonsense) {
  EXPECT_THAT(nearest_models(""), IsEmpty());
  EXPECT_THAT(nearest_models("qqqqqqqqqqqq"), IsEmpty());
  EXPECT_THAT(nearest_models("..."), IsEmpty());
}

}  // namespace
}  // namespace lidard
