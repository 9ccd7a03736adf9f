// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/nearest.h"

#include <gtest/gtest.h>

#include <string>

namespace lidard {
namespace {

TEST(EditDistance, CountsSingleSlips) {
  EXPECT_EQ(edit_distance("model", "model"), 0U);
  EXPECT_EQ(edit_distance("modl", "model"), 1U);
  EXPECT_EQ(edit_distance("moddel", "model"), 1U);
  EXPECT_EQ(edit_distance("modal", "model"), 1U);
  EXPECT_EQ(edit_distance("modle", "model"), 1U);
  EXPECT_EQ(edit_distance("", "model"), 5U);
  EXPECT_EQ(edit_distance("model", ""), 5U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
}

TEST(EditDistance, StaysCheapForHugeWords) {
  EXPECT_EQ(edit_distance(std::string(1000000, 'a'), std::string(1000000, 'b')), 64U);
}

TEST(NearestWord, IsThePlausibleOneOrNone) {
  EXPECT_EQ(nearest_word("ip_adress", {"ip_port", "ip_address", "interface"}), "ip_address");
  EXPECT_EQ(nearest_word("zzz", {"ip_port", "ip_address"}), "");
  EXPECT_EQ(nearest_word("", {"ip_port"}), "");
  EXPECT_EQ(nearest_word("b", {}), "");
  EXPECT_EQ(nearest_word("aa", {"ab", "ac"}), "ab");
}

}  // namespace
}  // namespace lidard
