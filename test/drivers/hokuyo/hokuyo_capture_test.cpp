// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/registry/registry.h"
#include "test/drivers/watched_capture.h"

namespace lidard::test {
namespace {

TEST(HokuyoCapture, AWholeConnectionOfAUst10lxGivesTheTruth) {
  WatchedCapture seen("hokuyo_ust_10lx", "hokuyo_ust_10lx");
  EXPECT_EQ(seen.identifier.verdict(), find_model("hokuyo_ust_10lx"));
  ASSERT_GE(seen.scans.size(), 7U);
  for (std::size_t i = 0; i < seen.scans.size(); ++i) {
    expect_truth(seen.scans[i], seen.truth.at(i), 0.03);
    EXPECT_NEAR(seconds(seen.scans[i].stamp - seen.truth[i].begin), 0, 2e-3);
    EXPECT_EQ(seen.scans[i].intensities.size(), 1081U);
  }
  EXPECT_EQ(seen.driver->info().serial, "H1234567");
}

TEST(HokuyoCapture, AStreamJoinedInTheMiddleIsReadByTheModelsGeometry) {
  WatchedCapture seen("hokuyo_ust_10lx_us", "hokuyo_ust_10lx");
  EXPECT_EQ(seen.identifier.verdict(), find_model("hokuyo_scip")) << "nothing in it names the product";
  ASSERT_GE(seen.scans.size(), 8U);
  for (const PlanarScan& scan : seen.scans) {
    ASSERT_EQ(scan.beams, 541U);
    EXPECT_NEAR(scan.angle_min, -134.875 * 3.14159265358979 / 180, 1e-5) << "the middle of steps 0 and 1";
  }
  // Each group holds the nearer of its two steps.
  const sim::Measurement& truth = seen.truth.at(0);
  for (std::size_t i = 0; i < 540; ++i) {
    const double nearer = std::min(truth.slots[2 * i].exact, truth.slots[2 * i + 1].exact);
    if (std::isfinite(nearer)) {
      EXPECT_NEAR(seen.scans[0].ranges[i], nearer, 0.00051) << i;
    }
  }
  EXPECT_EQ(seen.driver->counters().rejected_total(), 0U);
  EXPECT_EQ(seen.driver->counters().lost_packets, 0U);
}

TEST(HokuyoCapture, EchoesOfAUtmAreInTheOrderOfTheirDistance) {
  DriverConfig config;
  config.publish_multiecho = true;
  WatchedCapture seen("hokuyo_utm_30lx_ew", "hokuyo_utm_30lx_ew", config);
  EXPECT_EQ(seen.identifier.verdict(), find_model("hokuyo_utm_30lx_ew"));
  ASSERT_GE(seen.scans.size(), 5U);
  std::size_t second = 0;
  for (std::size_t s = 0; s < seen.scans.size(); ++s) {
    const PlanarScan& scan = seen.scans[s];
    ASSERT_EQ(scan.echoes, 3U);
    expect_truth(scan, seen.truth.at(s), 0.00051);
    for (std::size_t i = 0; i < scan.beams; ++i) {
      if (scan.statuses[scan.index(i, 1)] != BeamStatus::hit) continue;
      ++second;
      EXPECT_GT(scan.ranges[scan.index(i, 1)], scan.ranges[i] + 1);
    }
  }
  EXPECT_GT(second, seen.scans.size()) << "edges of pole and box";
}

TEST(HokuyoCapture, AUamTellsItsStateBesideItsScans) {
  WatchedCapture seen("hokuyo_uam_05lp", "hokuyo_uam_05lp");
  EXPECT_EQ(seen.identifier.verdict(), find_model("hokuyo_uam_05lp"));
  ASSERT_GE(seen.scans.size(), 8U);
  for (std::size_t s = 0; s < seen.scans.size(); ++s) expect_truth(seen.scans[s], seen.truth.at(s), 0.00051);
  ASSERT_EQ(seen.states.size(), seen.scans.size());
  const auto value = [&](std::string_view name) {
    for (const DeviceValue& each : seen.states[0].values) {
      if (each.name == name) return each.value;
    }
    return -1.0;
  };
  EXPECT_EQ(value("area"), 5);
  EXPECT_EQ(value("ossd1"), 0);
  EXPECT_EQ(value("ossd3"), 1);
  EXPECT_EQ(value("window_contaminated"), 1);
}

}  // namespace
}  // namespace lidard::test
