// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "drivers/registry/registry.h"
#include "test/drivers/sick/safety/safety_bench.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;

/// -1 if there is no such value.
double value_of(const DeviceState& state, const std::string& name) {
  for (const DeviceValue& each : state.values) {
    if (each.name == name) return each.value;
  }
  return -1;
}

TEST(SafetyTopics, AreNamedByTheModel) {
  const Model& model = *find_model("sick_nanoscan3");
  ASSERT_EQ(model.messages.size(), 2U);
  EXPECT_EQ(model.messages[0].name, "system_state");
  EXPECT_EQ(model.messages[1].name, "output_paths");
  EXPECT_EQ(model.extra_scans, (std::vector<std::string_view>{"intrusion", "beam_status"}));
  EXPECT_EQ(model.dialogue_port, 2122);
}

TEST(SafetyTopics, TellStateAndOutputPathsWithTheScansStamp) {
  SafetyBench bench;
  bench.sample.state_flags = 0x05;  // run mode, contamination warning
  bench.sample.cases = {{3, 0, 7, 0}};
  bench.send_next();
  ASSERT_EQ(bench.scans.size(), 1U);
  ASSERT_EQ(bench.states.size(), 2U);
  const DeviceState& system = bench.states[0];
  EXPECT_EQ(system.topic, "system_state");
  EXPECT_EQ(system.frame_id, "laser");
  EXPECT_EQ(system.stamp, bench.scans[0].stamp);
  EXPECT_EQ(value_of(system, "run_mode_active"), 1);
  EXPECT_EQ(value_of(system, "standby_mode_active"), 0);
  EXPECT_EQ(value_of(system, "contamination_warning"), 1);
  EXPECT_EQ(value_of(system, "contamination_error"), 0);
  EXPECT_EQ(value_of(system, "safe_cut_off_paths"), 0x55);
  EXPECT_EQ(value_of(system, "monitoring_case_1"), 3);
  EXPECT_EQ(value_of(system, "monitoring_case_3"), 7);
  const DeviceState& paths = bench.states[1];
  EXPECT_EQ(paths.topic, "output_paths");
  EXPECT_EQ(paths.stamp, bench.scans[0].stamp);
  EXPECT_EQ(value_of(paths, "active_monitoring_case"), 3);
  EXPECT_EQ(value_of(paths, "status_1"), 1);  // 0x11
  EXPECT_EQ(value_of(paths, "status_2"), 0);
  EXPECT_EQ(value_of(paths, "status_5"), 1);
  EXPECT_EQ(value_of(paths, "is_safe_1"), 1);
  EXPECT_EQ(value_of(paths, "is_safe_5"), 0);
  EXPECT_EQ(value_of(paths, "is_valid_12"), 1);
  EXPECT_EQ(value_of(paths, "is_valid_13"), 0);
}

TEST(SafetyTopics, MarkTheBeamsThatInterruptACutOffPathFromTheIntrusionBlock) {
  DriverConfig config;
  config.angle_min =
      (-10.5597 - 90 + 1.9 * 0.51306) * 3.14159265358979323846 / 180;  // leaves beams 0 and 1 out
  SafetyBench bench(config);
  bench.sample.intrusion[0] = Bytes(6, 0);
  bench.sample.intrusion[2] = Bytes(6, 0);
  bench.sample.intrusion[0][0] = 0x04;  // beam 2
  bench.sample.intrusion[2][0] = 0x0c;  // beams 2 and 3
  bench.sample.beams[3].status = 0x10;  // contamination is no intrusion
  bench.sample.beams[5].status = 0x11;
  bench.send_next();
  ASSERT_EQ(bench.extra_scans["intrusion"].size(), 1U);
  const PlanarScan& intrusion = bench.extra_scans["intrusion"][0];
  const PlanarScan& scan = bench.scans[0];
  ASSERT_EQ(intrusion.beams, 46U);
  EXPECT_EQ(intrusion.stamp, scan.stamp);
  EXPECT_EQ(intrusion.angle_min, scan.angle_min);
  EXPECT_EQ(intrusion.intensities[0], 5.0F);
  EXPECT_EQ(intrusion.intensities[1], 4.0F);
  EXPECT_FLOAT_EQ(intrusion.ranges[0], 1.408F);
  EXPECT_EQ(intrusion.statuses[1], BeamStatus::invalid) << "the device does not vouch for its range";
  for (std::size_t i = 2; i < intrusion.beams; ++i) {
    EXPECT_EQ(intrusion.intensities[i], 0.0F);
    EXPECT_TRUE(std::isnan(intrusion.ranges[i]));
  }
}

TEST(SafetyTopics, TellTheFlagsOfEachBeamWhereTheySayMoreThanTheRanges) {
  DriverConfig config;
  config.publish_intensity = false;
  config.angle_min =
      (-10.5597 - 90 + 1.9 * 0.51306) * 3.14159265358979323846 / 180;  // leaves beams 0 and 1 out
  SafetyBench bench(config);
  bench.sample.beams[1].status = 0x81;  // left out
  bench.sample.beams[2].status = 0x03;
  bench.send_next();
  EXPECT_TRUE(bench.extra_scans["beam_status"].empty());
  bench.sample.beams[4].status = 0x41;
  bench.sample.beams[5].status = 0xc3;
  bench.send_next();
  ASSERT_EQ(bench.extra_scans["beam_status"].size(), 1U);
  const PlanarScan& flags = bench.extra_scans["beam_status"][0];
  const PlanarScan& scan = bench.scans[1];
  ASSERT_EQ(flags.intensities.size(), 46U);
  EXPECT_EQ(flags.intensities[0], 3.0F);
  EXPECT_EQ(flags.intensities[1], 1.0F);
  EXPECT_EQ(flags.intensities[2], 65.0F);
  EXPECT_EQ(flags.intensities[3], 195.0F);
  EXPECT_EQ(flags.ranges[2], scan.ranges[2]);
  EXPECT_EQ(scan.statuses[2], BeamStatus::hit) << "what the flag means is unknown";
  EXPECT_EQ(scan.statuses[3], BeamStatus::none);
  EXPECT_EQ(flags.stamp, scan.stamp);
  EXPECT_EQ(flags.angle_min, scan.angle_min);
}

TEST(SafetyTopics, TellStateAndOutputPathsInStandbyAndWithoutBeamsToo) {
  DriverConfig config;
  config.angle_min = config.angle_max = 3;  // no beam is there
  for (const bool standby : {true, false}) {
    SafetyBench bench(standby ? DriverConfig() : config);
    bench.sample.state_flags = standby ? 0x02 : 0x01;
    bench.sample.with_measurement = !standby;
    bench.send_next();
    EXPECT_TRUE(bench.scans.empty());
    ASSERT_EQ(bench.states.size(), 2U);
    EXPECT_EQ(value_of(bench.states[0], "standby_mode_active"), standby ? 1 : 0);
    EXPECT_EQ(bench.states[1].topic, "output_paths");
    EXPECT_EQ(bench.states[1].frame_id, "laser");
    EXPECT_LT(std::abs(seconds(bench.states[0].stamp - bench.now)), 0.05);
  }
}

TEST(SafetyTopics, LeaveOutBlocksThatAreSwitchedOff) {
  SafetyBench bench;
  bench.sample.with_state = bench.sample.with_application = bench.sample.with_intrusion = false;
  bench.send_next();
  EXPECT_EQ(bench.scans.size(), 1U);
  EXPECT_TRUE(bench.states.empty());
  EXPECT_TRUE(bench.extra_scans["intrusion"].empty());
}

}  // namespace
}  // namespace lidard::sick
