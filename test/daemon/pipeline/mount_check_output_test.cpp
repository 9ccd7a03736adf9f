// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// A scanner that is not mounted as configured shows on /diagnostics of the merged scan.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/angle.h"
#include "daemon/health/pipeline_health.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/pipeline/pipeline.h"
#include "test/sim/world/flat_world.h"
#include "test/support/recording_sink.h"

namespace lidard {
namespace {

using ::testing::HasSubstr;

/// The merged scan's status after `seconds` of two scanners on the front corners, the right one turned and
/// shifted against its configured pose.
DiagnosticItem status_after(double seconds, double yaw_deg, double x) {
  const Config config = parse_config(
      "sensors:\n"
      "  left: {topic: /left, pose: {xyz: [0, 1, 0], rpy_deg: [0, 0, 45]}}\n"
      "  right: {topic: /right, pose: {xyz: [0, -1, 0], rpy_deg: [0, 0, -45]}}\n"
      "merged_scans: {around: {laserscan_topics: [left, right], destination_frame: base_link, range_max: "
      "24,\n"
      "                        profile: strict}}\n",
      "f");
  NoTransforms poses;
  test::RecordingSink sink{false};
  Pipeline pipeline(config, poses, sink);
  sim::FlatWorld room;
  room.add_box({0, 0}, {20, 12}, 0);
  room.add_box({2.5, 0}, {0.5, 0.5}, 0);
  sim::Rng rng(3);
  Stamp now{1'767'225'600'000'000'000};
  for (int i = 0; i < static_cast<int>(seconds * 25); ++i) {
    for (const double side : {1.0, -1.0}) {
      sim::FlatScanner scanner;
      scanner.at = {side < 0 ? x : 0, side};
      scanner.yaw = (side * 45 + (side < 0 ? yaw_deg : 0)) * pi_d / 180;
      scanner.increment = 0.5 * pi_d / 180;
      scanner.range_max = 40;
      scanner.noise = 0.01;
      PlanarScan scan;
      scanner.measure(room, rng, scan);
      scan.frame_id = side > 0 ? "left" : "right";
      scan.stamp = now;
      scan.scan_time = 0.04F;
      pipeline.scan_message(scan.frame_id, scan, now);
    }
    now = now + std::chrono::milliseconds(40);
    pipeline.tick(now);
  }
  sink.diagnostics(items_of(pipeline, now), now);
  return sink.item("merged around");
}

std::string mount_check_of(const DiagnosticItem& item) {
  for (const auto& [key, value] : item.values) {
    if (key == "Mount check left/right") return value;
  }
  return "no such value";
}

TEST(MountCheckOutput, IsFineWhenMountsAreAsConfigured) {
  const DiagnosticItem item = status_after(2.1, 0, 0);
  EXPECT_EQ(item.health, Health::ok) << item.message;
  EXPECT_THAT(mount_check_of(item), HasSubstr("surfaces; mount of right: yaw"));
}

TEST(MountCheckOutput, WarnsWithinTenSecondsOfAMountThatIsTurnedAndSaysByHowMuch) {
  const DiagnosticItem item = status_after(9, 0.5, 0);
  EXPECT_EQ(item.health, Health::warn);
  EXPECT_THAT(item.message, HasSubstr("left and right do not agree"));
  EXPECT_THAT(item.message, ::testing::ContainsRegex("since 00:00:0[01] UTC; `lidard calibrate"))
      << item.message;
  EXPECT_THAT(item.message, ::testing::ContainsRegex("right by yaw \\+0\\.(4|5)[0-9]+ deg")) << item.message;
}

TEST(MountCheckOutput, WarnsOfAMountThatIsFarFromItsPose) {
  const DiagnosticItem turned = status_after(9, 6, 0);
  EXPECT_EQ(turned.health, Health::warn);
  EXPECT_THAT(turned.message, ::testing::ContainsRegex("right by yaw \\+(5\\.9|6\\.0)[0-9]+ deg"));
  const DiagnosticItem lost = status_after(9, 80, 0);
  EXPECT_EQ(lost.health, Health::warn);
  EXPECT_THAT(lost.message,
              HasSubstr("right sees nothing of what left sees where their fields of view overlap; "
                        "check the pose of both (since 00:00:0"));
}

TEST(MountCheckOutput, WarnsOfAMountThatIsShifted) {
  const DiagnosticItem item = status_after(9, 0, 0.03);
  EXPECT_EQ(item.health, Health::warn);
  EXPECT_THAT(item.message, ::testing::ContainsRegex("x \\+0\\.0(2|3)[0-9] m")) << item.message;
}

}  // namespace
}  // namespace lidard
