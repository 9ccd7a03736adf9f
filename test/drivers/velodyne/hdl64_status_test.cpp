// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/velodyne/hdl64_status.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "test/support/allocations.h"

namespace lidard::velodyne {
namespace {

using ::testing::ElementsAre;
using ::testing::Pair;

/// What the factory wrote for one laser, in the units of the wire.
struct WireLaser {
  int vert, rot, far, x, y, v, h, focal_distance, focal_slope, min, max;
};

/// Writes the stream as the tables of 63-HDL64ES3 Rev K pp. 32-38 describe it; shares no code with the
/// reader.
class StatusStream {
 public:
  explicit StatusStream(bool s3, unsigned seed = 1) : s3_(s3) {
    std::mt19937 random(seed);
    const auto within = [&](int low, int high) {
      return low + static_cast<int>(random() % unsigned(high - low + 1));
    };
    for (int i = 0; i < 64; ++i)
      lasers.push_back({within(-2500, 500), within(-900, 900), within(1200, 1600), within(1200, 1600),
                        within(1200, 1600), within(100, 220), i % 2 == 0 ? 26 : -26, within(250, 24000),
                        within(4, 20), within(0, 50), within(200, 255)});
  }

  /// The type and value bytes of one round of 4160 packets.
  std::vector<std::pair<std::uint8_t, std::uint8_t>> round() const {
    const std::vector<int> bytes = calibration_bytes();
    std::vector<std::pair<std::uint8_t, std::uint8_t>> packets;
    for (int cycle = 0; cycle < 260; ++cycle) {
      const std::pair<char, int> begin[] = {{'H', 9},  {'M', 59},  {'S', second}, {'D', 24},  {'N', 12},
                                            {'Y', 16}, {'G', 'P'}, {'T', 0xF6},   {'V', 0x47}};
      for (const auto& [type, value] : begin) packets.emplace_back(type, value);
      for (int i = 0; i < 7; ++i) {
        const int at = cycle * 7 + i;
        if (s3_ && i == 0 && cycle >= 4 && cycle <= 252 && cycle % 4 == 0)
          packets.emplace_back('W', warnings);
        else
          packets.emplace_back(type_of(at), bytes[std::size_t(at)]);
      }
    }
    return packets;
  }

  void feed(Hdl64Status& status, std::size_t begin = 0, std::size_t end = 4160) const {
    const auto packets = round();
    for (std::size_t i = begin; i < end; ++i) status.add(packets[i].first, packets[i].second);
  }

  std::vector<WireLaser> lasers;
  int warnings = 0x21;
  int second = 30;
  int checksum_error = 0;
  bool has_date = true;

 private:
  static int type_of(int at) {
    switch (at - 1799) {  // cycle 258
      case 0:
        return 0xFE;
      case 1:
        return 0xFF;
      case 2:
        return 0xFC;
      case 3:
        return 0xFD;
      case 4:
        return 0xFA;
      case 5:
        return 0xFB;
      case 16:
        return 0xF9;
      case 18:
        return 0xF8;
      default:
        return '1' + at % 7;
    }
  }
  static void put16(std::vector<int>& bytes, int value) {
    bytes.push_back(value & 0xFF);
    bytes.push_back(value >> 8 & 0xFF);
  }
  /// Bit by bit, as the definition of a CRC has it.
  static int crc_of(const std::vector<int>& bytes) {
    unsigned remainder = 0;
    for (const int byte : bytes) {
      for (unsigned mask = 0x80; mask != 0; mask >>= 1) {
        const bool feedback = ((remainder & 0x8000U) != 0) != ((unsigned(byte) & mask) != 0);
        remainder = (remainder << 1 & 0xFFFF) ^ (feedback ? 0x8005U : 0U);
      }
    }
    return int(remainder);
  }
  std::vector<int> calibration_bytes() const {
    std::vector<int> bytes = {'U', 'N', 'I', 'T', '#', 24, 25};
    std::vector<int> checked;
    for (std::size_t i = 0; i < lasers.size(); ++i) {
      const WireLaser& l = lasers[i];
      std::vector<int> record;
      for (const int value : {l.vert, l.rot, l.far, l.x, l.y, l.v, l.h, l.focal_distance, l.focal_slope})
        put16(record, value);
      record.push_back(l.min);
      record.push_back(l.max);
      checked.insert(checked.end(), record.begin(), record.end());
      bytes.push_back(int(i));
      bytes.insert(bytes.end(), record.begin(), record.end());
      if (i < 63) bytes.insert(bytes.end(), 7, 0);
    }
    for (const int part : {15, 11, 14, 12, 47, 46}) bytes.push_back(has_date ? part : 0xFF);
    bytes.push_back(25);  // humidity
    put16(bytes, 600);    // rpm
    put16(bytes, 1000);   // field of view
    put16(bytes, 35000);
    put16(bytes, 2685);  // hours of life
    for (const int part : {192, 168, 3, 43, 192, 168, 3, 255}) bytes.push_back(part);
    bytes.push_back(2);  // both returns
    bytes.push_back(s3_ ? 0 : warnings);
    bytes.push_back(0xA0);
    put16(bytes, (s3_ ? crc_of(checked) : 1820) + checksum_error);
    return bytes;
  }
  bool s3_;
};

void expect_calibration(const Hdl64Status& status, const StatusStream& stream) {
  ASSERT_NE(status.calibration(), nullptr);
  const Calibration& calibration = *status.calibration();
  EXPECT_EQ(calibration.distance_step_m, 0.002);
  EXPECT_EQ(calibration.model, CalibrationModel::exact);
  ASSERT_EQ(calibration.lasers.size(), 64U);
  for (std::size_t i = 0; i < 64; ++i) {
    const LaserCalibration& laser = calibration.lasers[i];
    const WireLaser& wire = stream.lasers[i];
    EXPECT_NEAR(laser.vert_correction, wire.vert / 100.0 * M_PI / 180, 1e-12);
    EXPECT_NEAR(laser.rot_correction, wire.rot / 100.0 * M_PI / 180, 1e-12);
    EXPECT_NEAR(laser.dist_correction, wire.far / 1000.0, 1e-12);
    EXPECT_NEAR(laser.dist_correction_x, wire.x / 1000.0, 1e-12);
    EXPECT_NEAR(laser.dist_correction_y, wire.y / 1000.0, 1e-12);
    EXPECT_NEAR(laser.vert_offset, wire.v / 1000.0, 1e-12);
    EXPECT_NEAR(laser.horiz_offset, wire.h / 1000.0, 1e-12);
    EXPECT_NEAR(laser.focal_distance, wire.focal_distance / 1000.0, 1e-12);
    EXPECT_NEAR(laser.focal_slope, wire.focal_slope / 10.0, 1e-12);
    EXPECT_EQ(laser.min_intensity, wire.min);
    EXPECT_EQ(laser.max_intensity, wire.max);
    EXPECT_EQ(laser.two_point, TwoPoint::on);
  }
}

TEST(Hdl64Status, AnS3IsTrustedAfterOneRoundWithTheRightChecksum) {
  const StatusStream stream(true);
  Hdl64Status status;
  stream.feed(status, 3000);  // joined in the middle of a round
  stream.feed(status);
  EXPECT_EQ(status.calibration(), nullptr);  // the next round tells that this one was whole
  stream.feed(status, 0, 16);
  expect_calibration(status, stream);
  EXPECT_EQ(status.resynchronisations(), 0U);
}

TEST(Hdl64Status, AnS2IsTrustedAfterThreeEqualRounds) {
  const StatusStream stream(false);
  Hdl64Status status;
  for (int round = 0; round < 3; ++round) {
    stream.feed(status);
    EXPECT_EQ(status.calibration(), nullptr);
  }
  stream.feed(status, 0, 16);
  expect_calibration(status, stream);
}

TEST(Hdl64Status, AWrongChecksumMeansThreeRoundsForAnS3Too) {
  StatusStream stream(true);
  stream.checksum_error = 1;
  Hdl64Status status;
  for (int round = 0; round < 3; ++round) stream.feed(status);
  EXPECT_EQ(status.calibration(), nullptr);
  stream.feed(status, 0, 16);
  expect_calibration(status, stream);
}

TEST(Hdl64Status, RoundsThatDifferAreNotTrusted) {
  Hdl64Status status;
  for (unsigned round = 0; round < 8; ++round) StatusStream(false, round % 2).feed(status);
  EXPECT_EQ(status.calibration(), nullptr);
}

TEST(Hdl64Status, ANewCalibrationReplacesTheOldOne) {
  const StatusStream first(true, 1);
  const StatusStream second(true, 2);
  Hdl64Status status;
  for (int round = 0; round < 4; ++round) first.feed(status);
  const auto old = status.calibration();
  expect_calibration(status, first);
  second.feed(status);
  EXPECT_EQ(status.calibration(), old);
  second.feed(status, 0, 16);
  EXPECT_NE(status.calibration(), old);
  expect_calibration(status, second);
}

TEST(Hdl64Status, EqualRoundsKeepTheObjectAndAllocateNothing) {
  const StatusStream stream(true);
  const auto packets = stream.round();
  Hdl64Status status;
  for (int round = 0; round < 2; ++round) stream.feed(status);
  const auto calibration = status.calibration();
  ASSERT_NE(calibration, nullptr);
  const std::uint64_t before = test::allocations();
  for (const auto& [type, value] : packets) status.add(type, value);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(status.calibration(), calibration);
}

class Hdl64StatusLoss : public ::testing::TestWithParam<bool> {};

TEST_P(Hdl64StatusLoss, HolesAreFilledByLaterRounds) {
  const StatusStream stream(GetParam());
  const auto packets = stream.round();
  Hdl64Status status;
  std::mt19937 random(17);
  for (int round = 0; round < 30; ++round) {
    for (const auto& [type, value] : packets) {
      if (random() % 100 != 0) status.add(type, value);
    }
  }
  expect_calibration(status, stream);
  EXPECT_EQ(status.resynchronisations(), 0U);
}

TEST_P(Hdl64StatusLoss, LongGapsNeverGiveAWrongCalibration) {
  const StatusStream stream(GetParam());
  const auto packets = stream.round();
  Hdl64Status status;
  std::mt19937 random(19);
  std::size_t lost = 0;
  for (int round = 0; round < 60; ++round) {
    for (const auto& [type, value] : packets) {
      if (lost == 0 && random() % 3000 == 0) lost = random() % 300;
      if (lost > 0) {
        --lost;
      } else {
        status.add(type, value);
      }
    }
    if (status.calibration() != nullptr) expect_calibration(status, stream);
  }
  expect_calibration(status, stream);
  EXPECT_GT(status.resynchronisations(), 10U);
}

INSTANTIATE_TEST_SUITE_P(Series, Hdl64StatusLoss, ::testing::Bool(),
                         [](const auto& series) { return series.param ? "S3" : "S2"; });

TEST(Hdl64Status, TellsTimeGpsTemperatureAndFirmwareFromTheFirstCycleOn) {
  Hdl64Status status;
  StatusStream(true).feed(status, 0, 9);
  const Hdl64Info& info = status.info();
  ASSERT_TRUE(info.time);
  EXPECT_EQ(info.time->to_string(), "2016-12-24 09:59:30");
  EXPECT_EQ(info.gps, 'P');
  EXPECT_EQ(info.temperature, -10);
  EXPECT_EQ(info.firmware, 0x47);
  EXPECT_FALSE(info.settings);
}

TEST(Hdl64Status, PartsOfDifferentCyclesMakeNoDate) {
  const auto packets = StatusStream(true).round();
  Hdl64Status status;
  for (std::size_t i = 3; i < 16 + 3; ++i) status.add(packets[i].first, packets[i].second);
  EXPECT_FALSE(status.info().time);
}

TEST(Hdl64Status, TellsTheSettings) {
  const StatusStream stream(true);
  Hdl64Status status;
  stream.feed(status);
  stream.feed(status, 0, 16);
  EXPECT_THAT(
      hdl64_details(status.info()),
      ElementsAre(Pair("firmware_version", "4.07"), Pair("temperature_c", "-10"), Pair("gps", "PPS only"),
                  Pair("sensor_time", "2016-12-24 09:59:30"), Pair("series", "S3"), Pair("rpm", "600"),
                  Pair("fov_deg", "10.00 to 350.00"), Pair("return_mode", "both")));
}

TEST(Hdl64Status, WarningsComeFromTheirOwnTypeInAnS3AndFromTheSettingsInAnS2) {
  for (const bool s3 : {true, false}) {
    StatusStream stream(s3);
    stream.warnings = 0x0B;
    stream.has_date = false;
    Hdl64Status status;
    stream.feed(status);
    stream.feed(status, 0, 16);
    EXPECT_EQ(status.info().is_s3, s3);
    EXPECT_EQ(status.info().warnings, 0x0B);
    EXPECT_EQ(hdl64_warnings(status.info()).size(), s3 ? 2U : 3U);  // bit 3 means nothing in an S3
    ASSERT_TRUE(status.info().settings);
  }
}

TEST(Hdl64Status, RestartKeepsTheCalibrationAndFindsItsPlaceAgain) {
  const StatusStream stream(false);
  Hdl64Status status;
  for (int round = 0; round < 4; ++round) stream.feed(status);
  const auto calibration = status.calibration();
  ASSERT_NE(calibration, nullptr);
  status.restart();
  stream.feed(status, 777);
  for (int round = 0; round < 2; ++round) stream.feed(status);
  EXPECT_EQ(status.calibration(), calibration);
  EXPECT_EQ(status.resynchronisations(), 0U);
}

TEST(Hdl64Status, ConstantBytesOfOtherModelsGiveNothing) {
  Hdl64Status status;
  for (int i = 0; i < 20000; ++i) status.add(0x37, 0x22);
  EXPECT_EQ(status.calibration(), nullptr);
  EXPECT_FALSE(status.info().time);
}

TEST(Hdl64Status, RandomBytesGiveNoCalibration) {
  Hdl64Status status;
  std::mt19937 random(23);
  for (int i = 0; i < 200000; ++i)
    status.add(static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()));
  EXPECT_EQ(status.calibration(), nullptr);
}

}  // namespace
}  // namespace lidard::velodyne
