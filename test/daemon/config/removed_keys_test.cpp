// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config/values.h"

#include <gtest/gtest.h>

#include "test/daemon/config/config_support.h"

namespace lidard {
namespace {

TEST(RemovedKeys, AreAnsweredWithWhatToDoInstead) {
  EXPECT_EQ(test::merged_error("laserscan_topics: rear, conflicts: all"),
            "f:7:31: merged_scans.m.conflicts is a key of former versions; expected no such key: every "
            "return counts "
            "until its source sends a newer sweep");
  EXPECT_EQ(test::virtual_error("cloud_topic: roof, virtual_laser_scan: a, keep_ground: true"),
            "f:7:49: virtual_scans.v.keep_ground is a key of former versions; expected ground: none");
  EXPECT_EQ(
      test::error_of("sensors: {a: {model: velodyne_vlp16, frame_cut: time}}"),
      "f:1:38: sensors.a.frame_cut is a key of former versions; expected cut_angle: a frame is a revolution "
      "that ends there");
}

TEST(RemovedKeys, OfOneSectionMayBeKeysOfAnother) {
  EXPECT_NE(instead_of("merged_scans.m.source_settings.left.veil_filter"), "");
  EXPECT_EQ(instead_of("merged_scans.m.veil_filter"), "");
  EXPECT_NE(instead_of("merged_scans.m.source_settings.left.intensity_max"), "");
  EXPECT_EQ(instead_of("sensors.a.filter.intensity_min"), "");
}

}  // namespace
}  // namespace lidard
