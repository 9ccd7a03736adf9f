// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause

#include "test/drivers/sick/safety/safety_bench.h"

namespace lidard::sick {
namespace {

using namespace lidard::test;

TEST(SafetyStream, SendingOnlyEverySecondScanIsNoLoss) {
  SafetyBench bench;
  for (int i = 0; i < 20; ++i) {
    ++bench.sample.scan;
    bench.now = bench.now + std::chrono::milliseconds(30);
    bench.send_next();
  }
  EXPECT_EQ(bench.scans.size(), 20U);
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
  EXPECT_EQ(bench.driver->counters().clock_steps, 0U);
}

TEST(SafetyStream, SaysWhatToDoWhereSeveralStreamsComeToOnePlace) {
  const auto send = [](SafetyBench& bench, std::uint32_t serial, std::uint8_t channel, std::uint8_t host) {
    Ms3Sample other = bench.sample;
    other.serial = serial;
    other.channel = channel;
    for (const Bytes& datagram : ms3_datagrams(other.instance(), bench.identification++))
      bench.receive(packet_of(datagram, bench.now, host));
  };
  SafetyBench bench;
  bench.send_next();
  EXPECT_EQ(bench.device, "scanner " + std::to_string(bench.sample.serial));
  send(bench, bench.sample.serial + 1, 0, 21);
  EXPECT_EQ(bench.device, "scanner " + std::to_string(bench.sample.serial + 1));
  bench.send_next();
  EXPECT_EQ(bench.device, "scanner " + std::to_string(bench.sample.serial));
  EXPECT_EQ(bench.scans.size(), 2U);
  SafetyBench apart;
  apart.send_next();
  send(apart, apart.sample.serial + 1, 0, 22);
  EXPECT_TRUE(apart.has_warning("give each its own UDP port, or set ip_address"));
  SafetyBench channels;
  channels.send_next();
  send(channels, channels.sample.serial, 1, 21);
  EXPECT_TRUE(channels.has_warning("give each channel its own UDP port"));
}

TEST(SafetyStream, TwoScannersThatCountAlikeAreNoCopies) {
  SafetyBench bench;
  for (int i = 0; i < 30; ++i) {
    bench.send_next();
    Ms3Sample other = bench.sample;
    other.serial += 7;
    for (const Bytes& datagram : ms3_datagrams(other.instance(), bench.identification - 1))
      bench.receive(packet_of(datagram, bench.now));
    EXPECT_EQ(bench.device, "scanner " + std::to_string(other.serial));
  }
}

TEST(SafetyStream, SequenceNumberMayWrap) {
  SafetyBench bench;
  bench.sample.sequence = 0xfffffffdU;
  bench.sample.scan = 0xfffffffeU;
  for (int i = 0; i < 6; ++i) bench.send_next();
  EXPECT_EQ(bench.scans.size(), 6U);
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
  EXPECT_EQ(bench.driver->counters().clock_steps, 0U);
}

TEST(SafetyStream, LostDatagramCostsOneScan) {
  SafetyBench bench;
  bench.sample.beams.resize(537);
  bench.sample.step = 2151928;
  bench.send_next();
  ++bench.sample.sequence;
  ++bench.sample.scan;
  bench.now = bench.now + std::chrono::milliseconds(30);
  const auto parts = ms3_datagrams(bench.sample.instance(), bench.identification++);
  ASSERT_EQ(parts.size(), 2U);
  bench.driver->receive(packet_of(parts[0], bench.now), bench);
  bench.send_next();
  EXPECT_EQ(bench.scans.size(), 2U);
  EXPECT_EQ(bench.driver->counters().incomplete, 1U);
  EXPECT_EQ(bench.driver->counters().lost_packets, 1U);
  EXPECT_EQ(bench.driver->counters().packets, 5U);
}

TEST(SafetyStream, ADatagramThatIsHeldBackFor90MsIsLateAndOneFor110MsIsLost) {
  for (const int late_ms : {90, 110}) {
    SafetyBench bench;
    bench.sample.beams.resize(537);
    bench.sample.step = 2151928;
    bench.send_next();
    ++bench.sample.sequence;
    ++bench.sample.scan;
    bench.now = bench.now + std::chrono::milliseconds(30);
    const auto parts = ms3_datagrams(bench.sample.instance(), bench.identification++);
    ASSERT_EQ(parts.size(), 2U);
    bench.driver->receive(packet_of(parts[0], bench.now), bench);
    bench.now = bench.now + std::chrono::milliseconds(late_ms);
    bench.driver->tick(bench.now, bench);
    bench.driver->receive(packet_of(parts[1], bench.now), bench);
    const bool is_late = late_ms < 100;
    EXPECT_EQ(bench.scans.size(), is_late ? 2U : 1U);
    EXPECT_EQ(bench.driver->counters().incomplete, is_late ? 0U : 1U);
  }
}

TEST(SafetyStream, FinishCountsWhatNeverBecameWhole) {
  SafetyBench bench;
  bench.sample.beams.resize(537);
  bench.driver->receive(packet_of(ms3_datagrams(bench.sample.instance(), 1)[0]), bench);
  bench.driver->finish(bench);
  EXPECT_EQ(bench.driver->counters().incomplete, 1U);
}

TEST(SafetyStream, StandbyStopsScansAndWakingUpStampsRightAtOnce) {
  SafetyBench bench;
  for (int i = 0; i < 100; ++i) bench.send_next();
  bench.sample.state_flags = 2;
  bench.sample.with_measurement = false;
  for (int i = 0; i < 1000; ++i) {
    bench.send_next();
    --bench.sample.scan;
  }
  EXPECT_EQ(bench.scans.size(), 100U);
  EXPECT_EQ(bench.detail("Standby"), "yes");
  EXPECT_TRUE(bench.driver->info().warnings.empty());
  bench.sample.state_flags = 1;
  bench.sample.with_measurement = true;
  bench.sample.scan += 5;
  for (int i = 0; i < 100; ++i) {
    bench.send_next();
    EXPECT_NEAR(seconds(bench.now - bench.scans.back().stamp), 47 * seconds(beam_period), 1e-6);
  }
  EXPECT_EQ(bench.scans.size(), 200U);
  EXPECT_EQ(bench.detail("Standby"), "no");
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
  EXPECT_EQ(bench.driver->counters().clock_steps, 0U);
}

TEST(SafetyStream, RepeatedMeasurementInStandbyIsNotANewScan) {
  SafetyBench bench;
  bench.send_next();
  for (int i = 0; i < 10; ++i) {
    --bench.sample.scan;
    bench.send_next();
  }
  EXPECT_EQ(bench.scans.size(), 1U);
  EXPECT_EQ(bench.driver->counters().other_packets, 10U);
}

TEST(SafetyStream, PowerCycleStartsAgainWithoutFalseLosses) {
  SafetyBench bench;
  for (int i = 0; i < 100; ++i) bench.send_next();
  bench.sample.sequence = bench.sample.scan = 0;
  bench.now = bench.now + std::chrono::seconds(20);
  for (int i = 0; i < 10; ++i) bench.send_next();
  EXPECT_EQ(bench.scans.size(), 110U);
  EXPECT_EQ(bench.driver->counters().lost_packets, 0U);
  EXPECT_EQ(bench.driver->counters().clock_steps, 1U);
  EXPECT_NEAR(seconds(bench.now - bench.scans.back().stamp), 47 * seconds(beam_period), 1e-6);
}

TEST(SafetyStream, HostClockStepNeitherDropsNorFreezesScans) {
  for (const int step_s : {-3600, 3600}) {
    SafetyBench bench;
    for (int i = 0; i < 100; ++i) bench.send_next();
    bench.now = bench.now + std::chrono::seconds(step_s);
    for (int i = 0; i < 10; ++i) {
      bench.send_next();
      EXPECT_NEAR(seconds(bench.now - bench.scans.back().stamp), 47 * seconds(beam_period), 1e-6) << step_s;
    }
    EXPECT_EQ(bench.scans.size(), 110U);
    EXPECT_EQ(bench.driver->counters().clock_steps, 1U);
  }
}

}  // namespace
}  // namespace lidard::sick
