// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// CoLa at its limits: the longest numbers, windows of angles beside intensities and echoes, clocks that wrap,
// jump and rest.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "drivers/sick/cola/cola_stream.h"
#include "test/drivers/sick/cola/cola_bench.h"

namespace lidard::test {
namespace {

using sick::ColaTextReader;

/// What a field reads as, or nothing where it is refused.
template <class Read>
std::optional<std::int64_t> number_of(const std::string& text, Read read) {
  ColaTextReader reader{ByteView(text)};
  const auto value = static_cast<std::int64_t>(read(reader));
  return reader.ok() ? std::optional<std::int64_t>(value) : std::nullopt;
}
std::optional<std::int64_t> u32(const std::string& text) {
  return number_of(text, [](ColaTextReader& r) { return r.u32(); });
}
std::optional<std::int64_t> u16(const std::string& text) {
  return number_of(text, [](ColaTextReader& r) { return r.u16(); });
}
std::optional<std::int64_t> i16(const std::string& text) {
  return number_of(text, [](ColaTextReader& r) { return r.i16(); });
}
std::optional<std::int64_t> i32(const std::string& text) {
  return number_of(text, [](ColaTextReader& r) { return r.i32(); });
}

// SICK telegram listing 8014631, 2.2: numbers are hexadecimal, or decimal with a sign in front.
TEST(ColaNumbers, ReachFromTheLowestToTheHighestOfTheirType) {
  EXPECT_EQ(u32("+4294967295"), 4294967295);
  EXPECT_EQ(u32("+4294967296"), std::nullopt);
  EXPECT_EQ(u32("+1000000000"), 1000000000) << "ten digits";
  EXPECT_EQ(u32("FFFFFFFF"), 4294967295);
  EXPECT_EQ(u32("100000000"), std::nullopt);
  EXPECT_EQ(u32("00FFFFFFFF"), 4294967295) << "ten digits, two of them for nothing";
  EXPECT_EQ(u32("000FFFFFFFF"), std::nullopt) << "no device sends eleven";
  EXPECT_EQ(u32("abcdef01"), 0xABCDEF01);
  EXPECT_EQ(u32("+0"), 0);
  EXPECT_EQ(u16("FFFF"), 65535);
  EXPECT_EQ(u16("10000"), std::nullopt);
  EXPECT_EQ(u16("+65535"), 65535);
  EXPECT_EQ(u16("+65536"), std::nullopt);
  EXPECT_EQ(i16("-32768"), -32768);
  EXPECT_EQ(i16("8000"), -32768);
  EXPECT_EQ(i16("7FFF"), 32767);
  EXPECT_EQ(i16("-1"), -1);
  EXPECT_EQ(i32("-2147483648"), -2147483648LL);
  EXPECT_EQ(i32("FFF92230"), -450000);
  EXPECT_EQ(i32("-450000"), -450000);
}

TEST(ColaNumbers, AreRefusedWhereACharacterIsNoDigitOfTheirBase) {
  for (const char* bad : {"+", "-", "+A", "-F", "G", "@", "`", "g", ":", "/", "1.5", "0x10", "+-1"})
    EXPECT_EQ(u32(bad), std::nullopt) << bad;
  for (const char* good : {"0", "9", "A", "F", "a", "f"}) EXPECT_NE(u32(good), std::nullopt) << good;
}

TEST(ColaWindow, IntensitiesOfAnotherNumberThanTheDistancesAreLeftAtZero) {
  ColaBench bench;
  bench.sample.channels = {{"DIST1", 1, 0, -450000, 5000, true, {1000, 1001, 1002}},
                           {"RSSI1", 1, 0, -450000, 5000, true, {7, 8}}};
  bench.send_sample();
  EXPECT_THAT(bench.scans.at(0).intensities, testing::ElementsAre(0, 0, 0));
}

/// s between the stamps of scans and when they began, the smallest of them taken away.
double spread(const std::vector<double>& errors) {
  return *std::max_element(errors.begin(), errors.end()) - *std::min_element(errors.begin(), errors.end());
}

TEST(ColaStamps, GoOnOverEveryWrapOfTheMicrosecondsAlsoInASilence) {
  for (const double silence_s : {0.0, 3000.0, 4294.9, 4295.1, 9000.0, 40000.0}) {
    ColaBench bench;
    std::vector<double> errors;
    for (int i = 0; i < 60; ++i) {
      if (i == 30) {
        const auto silence_us = static_cast<std::int64_t>(silence_s * 1e6);
        bench.now = bench.now + std::chrono::microseconds(silence_us);
        bench.sample.start_us += static_cast<std::uint32_t>(silence_us);
        bench.sample.transmit_us += static_cast<std::uint32_t>(silence_us);
      }
      bench.send_next();
      errors.push_back(seconds(bench.now - bench.scans.back().stamp));
    }
    EXPECT_LT(spread(errors), 0.2e-3) << silence_s;
    EXPECT_EQ(bench.counters().clock_steps, 0U) << silence_s;
  }
}

TEST(ColaStamps, AWayFromMeasuringToSendingOfTenSecondsOrMoreIsNone) {
  // The first beam is measured at start_us; the telegram leaves at transmit_us and arrives at once.
  const auto behind = [](std::uint32_t way_us) {
    DriverConfig config;
    config.clock = ClockMode::arrival;
    ColaBench bench("sick_lms5xx", config);
    bench.sample.transmit_us = bench.sample.start_us + way_us;
    bench.send_sample();
    return seconds(bench.now - bench.scans.at(0).stamp);
  };
  EXPECT_NEAR(behind(3'000), 0.003, 1e-6);
  EXPECT_NEAR(behind(10'000'000), 10, 1e-6);
  const double sweep = 540 * 0.5 / 360 * 0.02;
  EXPECT_NEAR(behind(10'000'001), sweep, 1e-5);
  EXPECT_NEAR(behind(static_cast<std::uint32_t>(-5)), sweep, 1e-5) << "sent before it was measured";
}

}  // namespace
}  // namespace lidard::test
