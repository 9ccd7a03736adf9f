// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/nmea.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "test/drivers/velodyne/telemetry_bench.h"

namespace lidard::velodyne {
namespace {

using test::sentence;

NmeaReading rmc(const std::string& fields) { return read_nmea(sentence("GPRMC," + fields)); }
NmeaReading gga(const std::string& fields) { return read_nmea(sentence("GPGGA," + fields)); }

// As recorded from a VLP-16; the checksum is the receiver's.
constexpr const char* real_rmc =
    "$GPRMC,081802.00,A,3649.7478558,N,00224.4542928,W,0.034,212.5,210116,0.0,E,A*2E\r\n";

TEST(Nmea, ReadsARealRmcSentence) {
  const NmeaReading reading = read_nmea(real_rmc);
  ASSERT_EQ(reading.verdict, NmeaVerdict::valid);
  EXPECT_EQ(reading.kind, NmeaKind::rmc);
  ASSERT_TRUE(reading.utc);
  EXPECT_EQ(reading.utc->ns, 1'453'364'282'000'000'000);
  EXPECT_NEAR(reading.latitude_deg, 36.829130930, 1e-9);
  EXPECT_NEAR(reading.longitude_deg, -2.407571547, 1e-9);
  EXPECT_TRUE(std::isnan(reading.altitude_m));
  EXPECT_EQ(reading.status, FixStatus::satellite);
}

TEST(Nmea, ReadsGgaWithItsAltitudeAboveTheEllipsoid) {
  const auto reading = gga("123519.25,4807.038,S,01131.000,E,4,08,0.9,545.4,M,-46.9,M,,");
  ASSERT_EQ(reading.verdict, NmeaVerdict::valid);
  EXPECT_EQ(reading.kind, NmeaKind::gga);
  EXPECT_EQ(reading.time_of_day, std::chrono::milliseconds(45'319'250));
  EXPECT_FALSE(reading.utc);
  EXPECT_NEAR(reading.latitude_deg, -48.1173, 1e-9);
  EXPECT_NEAR(reading.longitude_deg, 11.0 + 31.0 / 60, 1e-9);
  EXPECT_NEAR(reading.altitude_m, 498.5, 1e-9);
  EXPECT_EQ(reading.status, FixStatus::gbas);
  const auto without_geoid = gga("123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,,M,,");
  EXPECT_EQ(without_geoid.verdict, NmeaVerdict::valid);
  EXPECT_TRUE(std::isnan(without_geoid.altitude_m));
}

TEST(Nmea, ReadsTimesWithNoneToThreeDecimals) {
  const std::string rest = ",A,3649.7,N,00224.4,W,0,0,210116";
  constexpr Span whole = std::chrono::seconds(8 * 3600 + 18 * 60 + 2);
  EXPECT_EQ(rmc("081802" + rest).time_of_day, whole);
  EXPECT_EQ(rmc("081802.5" + rest).time_of_day, whole + std::chrono::milliseconds(500));
  EXPECT_EQ(rmc("081802.05" + rest).time_of_day, whole + std::chrono::milliseconds(50));
  EXPECT_EQ(rmc("081802.005" + rest).time_of_day, whole + std::chrono::milliseconds(5));
  EXPECT_EQ(rmc("235960" + rest).time_of_day, std::chrono::hours(24));
  for (const char* time :
       {"", "0818", "081802.", "081802,5", "081802.5a", "241802", "086002", "081861", "-81802", "08180 "}) {
    EXPECT_EQ(rmc(time + rest).verdict, NmeaVerdict::malformed) << time;
  }
}

TEST(Nmea, KnowsTheCalendar) {
  const auto day = [](const std::string& date) { return rmc("000000,A,0000.0,N,00000.0,E,0,0," + date); };
  const auto days = [&](const std::string& date) {
    return day(date).utc ? day(date).utc->ns / 86'400'000'000'000 : -1;
  };
  EXPECT_EQ(days("010101"), 11323);
  EXPECT_EQ(days("290224"), 19782);
  EXPECT_EQ(days("010324"), 19783);
  EXPECT_EQ(days("311225"), 20453);
  EXPECT_EQ(days("311279"), 40176);
  for (const char* date :
       {"290223", "310424", "001224", "011324", "010024", "0101", "01012024", "0a0124", ""})
    EXPECT_EQ(day(date).verdict, NmeaVerdict::malformed) << date;
}

TEST(Nmea, DoesNotBelieveDatesBeforeTheFirstVelodyne) {
  const auto day = [](const std::string& date) {
    return rmc("000001,A,3649.7,N,00224.4,W,0,0," + date).verdict;
  };
  EXPECT_EQ(day("010100"), NmeaVerdict::invented_date);
  EXPECT_EQ(day("311200"), NmeaVerdict::invented_date);
  EXPECT_EQ(day("220899"), NmeaVerdict::invented_date);
  EXPECT_EQ(day("010101"), NmeaVerdict::valid);
}

TEST(Nmea, TakesTheReceiversWordThatItHasNoFix) {
  EXPECT_EQ(rmc("081802,V,,,,,,,210116,,,N").verdict, NmeaVerdict::no_fix);
  EXPECT_EQ(rmc("081802,V,3649.7,N,00224.4,W,0,0,210116").verdict, NmeaVerdict::no_fix);
  EXPECT_EQ(rmc("081802,A,3649.7,N,00224.4,W,0,0,210116,,,E").verdict, NmeaVerdict::no_fix);
  EXPECT_EQ(gga("081802,,,,,0,00,,,M,,M,,").verdict, NmeaVerdict::no_fix);
  EXPECT_EQ(gga("081802,3649.7,N,00224.4,W,6,00,,,M,,M,,").verdict, NmeaVerdict::no_fix);
}

TEST(Nmea, RefusesImpossiblePositions) {
  const auto at = [](const std::string& position) {
    return rmc("081802,A," + position + ",0,0,210116").verdict;
  };
  EXPECT_EQ(at("3649.7,N,00224.4,W"), NmeaVerdict::valid);
  for (const char* position :
       {"9000.1,N,00224.4,W", "3660.0,N,00224.4,W", "3649.7,X,00224.4,W", "3649.7,N,18000.1,W",
        "3649.7,N,0224.4,W", "3649.7,N,00224.4,", "nan,N,00224.4,W", "36-9.7,N,00224.4,W",
        "3649.7e1,N,00224.4,W", ",N,00224.4,W", "3649.7,NN,00224.4,W", "inf,N,inf,W"}) {
    EXPECT_EQ(at(position), NmeaVerdict::malformed) << position;
  }
}

TEST(Nmea, NeedsARightChecksum) {
  std::string text = real_rmc;
  text[10] = '9';
  EXPECT_EQ(read_nmea(text).verdict, NmeaVerdict::bad_checksum);
  EXPECT_EQ(read_nmea("$GPRMC,081802.00,A,3649.7478558,N,00224.4542928,W").verdict,
            NmeaVerdict::bad_checksum);
  text = real_rmc;
  EXPECT_EQ(read_nmea(text.substr(0, text.find('*') + 2)).verdict, NmeaVerdict::bad_checksum);
  EXPECT_EQ(read_nmea(text.substr(0, text.find('*') + 3) + "0").verdict, NmeaVerdict::bad_checksum);
  text.replace(text.find("2E"), 2, "2e");
  EXPECT_EQ(read_nmea(text).verdict, NmeaVerdict::valid);
}

TEST(Nmea, NamesWhatIsNoSentenceOfOurs) {
  EXPECT_EQ(read_nmea("").verdict, NmeaVerdict::absent);
  EXPECT_EQ(read_nmea("\r\n").verdict, NmeaVerdict::absent);
  EXPECT_EQ(read_nmea("GPRMC,1").verdict, NmeaVerdict::malformed);
  EXPECT_EQ(read_nmea("*00").verdict, NmeaVerdict::malformed);
  EXPECT_EQ(read_nmea("$" + std::string(30, ',') + "*00").verdict, NmeaVerdict::malformed);
  EXPECT_EQ(read_nmea(sentence("GPVTG,1,T,2,M")).verdict, NmeaVerdict::other_sentence);
  EXPECT_EQ(read_nmea(sentence("RMC,1")).verdict, NmeaVerdict::other_sentence);
  EXPECT_EQ(read_nmea(sentence("GNRMC,081802,A,3649.7,N,00224.4,W,0,0,210116")).verdict, NmeaVerdict::valid);
}

TEST(Nmea, SurvivesJunkAndNeverBelievesImpossibleValues) {
  std::mt19937 random(20260101);
  std::size_t valid = 0;
  for (int round = 0; round < 200'000; ++round) {
    std::string body = round % 2 != 0 ? std::string(real_rmc).substr(1, 73)
                                      : "GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,";
    for (auto changes = random() % 4; changes > 0; --changes) {
      const std::size_t at = random() % body.size();
      if (random() % 3 == 0)
        body.erase(at, random() % 5);
      else
        body[at] = random() % 4 == 0 ? static_cast<char>(random() % 256) : ",.*$-0159NWAVe\0"[random() % 16];
      if (body.empty()) body = ",";
    }
    // The checksum is right, so that the fields are read.
    const NmeaReading reading = read_nmea(sentence(body));
    if (reading.verdict != NmeaVerdict::valid) continue;
    ++valid;
    ASSERT_LE(std::abs(reading.latitude_deg), 90) << body;
    ASSERT_LE(std::abs(reading.longitude_deg), 180) << body;
    ASSERT_GE(reading.time_of_day.count(), 0) << body;
    ASSERT_LE(reading.time_of_day, std::chrono::seconds(86'401)) << body;
    ASSERT_NE(reading.status, FixStatus::none) << body;
  }
  EXPECT_GT(valid, 50'000U);
  EXPECT_LT(valid, 180'000U);
}

}  // namespace
}  // namespace lidard::velodyne
