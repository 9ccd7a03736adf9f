// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/telemetry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/velodyne/packet.h"
#include "test/drivers/velodyne/telemetry_bench.h"

namespace lidard::velodyne {
namespace {

using test::TelemetryBytes;

TEST(Telemetry, HasExactly512Bytes) {
  const std::array<std::uint8_t, 1206> bytes{};
  for (const std::size_t size : {0U, 1U, 0xC6U, 511U, 513U, 554U, 1206U})
    EXPECT_FALSE(read_telemetry(ByteView(bytes.data(), size))) << size;
  EXPECT_TRUE(read_telemetry(ByteView(bytes.data(), 512)));
}

TEST(Telemetry, OfAnOldSensorHasNeitherTemperaturesNorImu) {
  TelemetryBytes packet;
  packet.toh(332.921185).pps(Pps::absent);
  const auto telemetry = read_telemetry(packet.view());
  ASSERT_TRUE(telemetry);
  EXPECT_EQ(telemetry->toh_us, 332'921'185U);
  EXPECT_TRUE(telemetry->is(Pps::absent));
  EXPECT_FALSE(telemetry->health);
  EXPECT_FALSE(telemetry->imu);
  EXPECT_EQ(telemetry->nmea, "");
}

TEST(Telemetry, OfNewFirmwareHasTemperatures) {
  TelemetryBytes packet;
  packet.little(0xBB, 53, 1).little(0xBC, 0xFB, 1).little(0xBD, 41, 1).little(0xBE, 0xFFFD, 2);
  packet.little(0xC0, 70'000, 4).little(0xC4, 3, 1).little(0xC5, 2, 1);
  packet.little(0xCB, 1, 1).little(0xCC, 90, 1).little(0xCD, 0xEC, 1);
  const auto telemetry = read_telemetry(packet.view());
  ASSERT_TRUE(telemetry && telemetry->health);
  const SensorHealth& health = *telemetry->health;
  EXPECT_EQ(health.top_board_c, 53);
  EXPECT_EQ(health.bottom_board_c, -5);
  EXPECT_EQ(health.since_calibration_k, -3);
  EXPECT_EQ(health.calibration_age_s, 70'000U);
  EXPECT_TRUE(health.shut_down);
}

TEST(Telemetry, TakesTheSentenceUpToTheNulOrTheEndOfItsField) {
  TelemetryBytes packet;
  packet.nmea("$GPRMC,1\r\n").little(0xCE + 20, 'x', 1);
  EXPECT_EQ(read_telemetry(packet.view())->nmea, "$GPRMC,1\r\n");
  packet.nmea(std::string(200, 'y')).little(0xCE + 128, 'z', 1);
  EXPECT_EQ(read_telemetry(packet.view())->nmea, std::string(128, 'y'));
}

TEST(Telemetry, ReadsTheTwelveBitWordsOfTheImu) {
  TelemetryBytes packet;
  // As recorded from an HDL-32E.
  constexpr std::array<std::uint16_t, 12> words = {0x0F70, 0x104B, 0x230C, 0x3115, 0x0FCB, 0x105D,
                                                   0x2307, 0x3FC8, 0x0EBF, 0x1074, 0x2F01, 0x3FC6};
  for (std::size_t i = 0; i < words.size(); ++i) packet.little(14 + 2 * i, words[i], 2);
  const auto telemetry = read_telemetry(packet.view());
  ASSERT_TRUE(telemetry && telemetry->imu);
  const auto turn = telemetry->imu->angular_velocity();
  EXPECT_NEAR(turn[0], -0.09033789, 1e-8);
  EXPECT_NEAR(turn[1], 0.24544635, 1e-8);
  EXPECT_NEAR(turn[2], -0.54714082, 1e-8);
  const auto push = telemetry->imu->linear_acceleration();
  EXPECT_NEAR(push[0], 3.18506263, 1e-8);
  EXPECT_NEAR(push[1], -0.68251342, 1e-8);
  EXPECT_NEAR(push[2], 9.30972253, 1e-8);
  EXPECT_NEAR(telemetry->imu->temperature_c[0], 35.8975, 1e-9);
  packet.little(14 + 2 * 5, 0x205D, 2);
  EXPECT_FALSE(read_telemetry(packet.view())->imu) << "a word that is not of its kind";
}

TEST(HourDifference, GoesTheShorterWayRound) {
  using std::chrono::seconds;
  EXPECT_EQ(hour_difference(seconds(3599), seconds(1)), seconds(-2));
  EXPECT_EQ(hour_difference(seconds(1), seconds(3599)), seconds(2));
  EXPECT_EQ(hour_difference(seconds(1800), seconds(0)), seconds(1800));
  EXPECT_EQ(hour_difference(seconds(0), seconds(1800)), seconds(1800));
  EXPECT_EQ(hour_difference(seconds(3601), seconds(3599)), seconds(2)) << "a counter past the hour";
  EXPECT_EQ(hour_difference(seconds(36'005), seconds(7'210)), seconds(-5));
}

TEST(Telemetry, AnyBytesCanBeReadAndJudged) {
  std::mt19937 random(8308);
  TelemetryBytes start;
  start.toh(3599.9).pps(Pps::locked);
  start.nmea(test::sentence("GPRMC,081802.00,A,3649.7478558,N,00224.4542928,W,0.034,212.5,210116,0.0,E,A"));
  test::TelemetryBench bench(true);
  Stamp arrival{1'453'364'282'000'000'000};
  for (int round = 0; round < 100'000; ++round) {
    TelemetryBytes packet = start;
    for (auto changes = random() % 20; changes > 0; --changes)
      packet.bytes[random() % 512] = static_cast<std::uint8_t>(random());
    if (round % 50 == 0) {
      for (auto& byte : packet.bytes) byte = static_cast<std::uint8_t>(random());
    }
    arrival = arrival + Span(static_cast<std::int64_t>(random() % 1'000'000'000) - 100'000'000);
    ASSERT_EQ(bench.give(packet.view(), arrival), Reject::none);
    ASSERT_LE(bench.info.warnings.size(), 1U);
    ASSERT_LE(bench.info.details.size(), 13U);
  }
  EXPECT_GT(bench.receiver->bad_sentences(), 1000U);
}

}  // namespace
}  // namespace lidard::velodyne
