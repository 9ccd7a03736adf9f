// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// When the scans of a CoLa device were measured.
#include "test/drivers/sick/cola/cola_bench.h"

namespace lidard::test {
namespace {

using sim::Cola;

TEST(ColaDriver, StampIsThatOfTheFirstBeam) {
  ColaBench last("sick_lms1xx"), first("sick_lms5xx");
  for (ColaBench* bench : {&last, &first}) bench->send_sample();
  const Stamp start = last.now - std::chrono::milliseconds(3);  // transmitted 3 ms later, arrived at once
  EXPECT_EQ(first.scans.at(0).stamp, start);
  const Span sweep = span_from_seconds(540 * 0.02 * 0.5 / 360);
  EXPECT_NEAR(static_cast<double>((last.scans.at(0).stamp - (start - sweep)).count()), 0, 10);
}

// Telegrams of an LMS151 at 25 Hz were sent 45 ms after their stamp, those of an LMS111 at 50 Hz 3 ms.
TEST(ColaDriver, AStampLongBeforeTheTransmissionIsThatOfTheFirstBeam) {
  for (const auto& [way_us, age] : {std::pair(45'500, 0.0455), std::pair(3000, 0.033)}) {
    ColaBench bench;
    bench.sample.scan_frequency = 2500;
    bench.sample.measurement_frequency = 180;
    bench.sample.transmit_us = bench.sample.start_us + static_cast<std::uint32_t>(way_us);
    for (int i = 0; i < 20; ++i) bench.send_next();
    EXPECT_NEAR(seconds(bench.now - bench.scans.back().stamp), age, 1e-3) << way_us;
  }
}

TEST(ColaDriver, AChangeOfTheRateChangesWhatAStampIs) {
  ColaBench bench;
  const auto send = [&](std::uint32_t rate, std::uint32_t way_us) {
    bench.sample.scan_frequency = rate;
    bench.sample.measurement_frequency = rate / 100 * 7;
    bench.sample.transmit_us = bench.sample.start_us + way_us;
    for (int i = 0; i < 20; ++i) bench.send_next();
  };
  send(5000, 3000);
  send(2500, 45'500);
  EXPECT_NEAR(seconds(bench.now - bench.scans.back().stamp), 0.0455, 1e-3);
}

TEST(ColaDriver, WithoutATimeOfTransmissionAStampOfTheLastBeamIsTheArrival) {
  ColaBench bench;
  for (int i = 0; i < 20; ++i) {
    bench.sample.transmit_us = 0U - 20'000U;  // send_next() adds a period of 20 ms
    bench.send_next();
  }
  const double sweep = 540 * static_cast<double>(bench.scans.back().time_increment);
  EXPECT_NEAR(seconds(bench.now - bench.scans.back().stamp), sweep, 1e-4);
}

TEST(ColaDriver, WithoutATimeOfTransmissionStampsAreRightBeforeTheCounterOverflows) {
  ColaBench bench;
  bench.sample.start_us = 0xFFFFFFFF - 5'000'000;
  for (int i = 0; i < 500; ++i) {
    bench.sample.transmit_us = 0U - 20'000U;  // send_next() adds a period of 20 ms
    bench.send_next();
    ASSERT_LT(std::abs(seconds(bench.now - bench.scans.back().stamp)), 0.1) << i;
  }
}

// The counter of microseconds overflows after 71.6 min: a device that was off for 90 min seems to have
// counted on for 18 or 55 min.
TEST(ColaDriver, APowerCycleOfAnyLengthPutsNoScanIntoThePast) {
  for (const int off_s : {5, 2400, 5400, 9000}) {
    for (const bool is_new_connection : {true, false}) {
      SCOPED_TRACE(off_s);
      ColaBench bench;
      bench.sample.start_us = 1'000'000'000;
      bench.sample.transmit_us = bench.sample.start_us + 3000;
      for (int i = 0; i < 100; ++i) bench.send_next();
      bench.now = bench.now + std::chrono::seconds(off_s);
      bench.sample.start_us = 20'000'000;
      bench.sample.transmit_us = bench.sample.start_us + 3000;
      const std::size_t before = bench.scans.size();
      bench.send(bench.sample.bytes(Cola::binary), 0, is_new_connection);
      bench.send_next();
      ASSERT_EQ(bench.scans.size(), before + 2);
      EXPECT_NEAR(seconds(bench.now - bench.scans.back().stamp), 0.018, 0.001);
    }
  }
}

/// Makes the next `count` scans of a row and gives them to the driver in one read, 2 ms after the last one.
void read_at_once(ColaBench& bench, int count) {
  std::vector<std::uint8_t> bytes;
  for (int i = 0; i < count; ++i) {
    bench.now = bench.now + std::chrono::milliseconds(20);
    bench.sample.start_us += 20'000;
    bench.sample.transmit_us += 20'000;
    ++bench.sample.telegram_counter;
    ++bench.sample.scan_counter;
    const auto telegram = bench.sample.bytes(bench.dialect);
    bytes.insert(bytes.end(), telegram.begin(), telegram.end());
  }
  EXPECT_EQ(bench.send(bytes), Reject::none);
}

TEST(ColaDriver, ScansThatWaitedForOneReadKeepTheDevicesIntervals) {
  for (const Cola dialect : {Cola::binary, Cola::text}) {
    for (const int before : {0, 1, 50}) {
      ColaBench bench;
      bench.dialect = dialect;
      for (int i = 0; i < before; ++i) bench.send_next();
      read_at_once(bench, 7);
      read_at_once(bench, 25);
      bench.send_next();
      ASSERT_EQ(bench.scans.size(), static_cast<std::size_t>(before) + 33);
      for (std::size_t i = 1; i < bench.scans.size(); ++i)
        EXPECT_NEAR(seconds(bench.scans[i].stamp - bench.scans[i - 1].stamp), 0.02, 1e-4)
            << before << ": " << i;
      EXPECT_EQ(bench.counters().packets, bench.scans.size());
      EXPECT_EQ(bench.counters().rejected_total() + bench.counters().lost_packets, 0U);
    }
  }
}

}  // namespace
}  // namespace lidard::test
