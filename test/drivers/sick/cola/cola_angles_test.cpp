// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The angles of a NAV, compensated by its answer to MCAngleCompSin. Answers, formulas and table: sick_scan_xd
// 3.9.0 (angle_compensator.cpp, doc/angular_compensation.md).
#include <gmock/gmock.h>

#include <cmath>

#include "core/evidence/beam_rays.h"
#include "core/frames/scan_points.h"
#include "test/drivers/sick/cola/cola_bench.h"

namespace lidard::test {
namespace {

std::vector<std::uint8_t> binary_answer(const std::string& values) {
  return sim::ColaWords(sim::Cola::binary, "sRA MCAngleCompSin " + values).bytes();
}
std::vector<std::uint8_t> text_answer(const std::string& values) {
  const std::string text = "\2sRA MCAngleCompSin " + values + "\3";
  return {text.begin(), text.end()};
}

const std::string nav2xx_bytes("\x00\x00\x07\x65\xff\xfc\xc9\xb9\xff\xff\xff\x0b", 12);
const std::string nav3xx_bytes("\x03\x37\x00\x1d\x8e\x8d\x00\xe7", 8);

/// A turn in steps of 5 degrees.
void turn(ColaBench& bench, std::int32_t start_deg, std::size_t beams = 72) {
  bench.sample.channels = {
      {"DIST1", 1, 0, start_deg * 10000, 50000, true, std::vector<std::uint16_t>(beams, 10000)}};
}

/// Degrees of a beam, wrapped to the turn around `near`.
double deg_of(const PlanarScan& scan, std::size_t beam, double near) {
  const double deg = static_cast<double>(scan.angle(beam)) * deg_per_rad;
  return near + std::remainder(deg - near, 360);
}

double sine(double deg) { return std::sin(deg * rad_per_deg); }

TEST(ColaAngles, OfANav2xxAreCompensatedByEveryFormOfItsAnswer) {
  for (const auto& answer : {binary_answer(nav2xx_bytes), text_answer("765 FFFCC9B9 FFFFFF0B"),
                             text_answer("+1893 -210503 -245")}) {
    ColaBench bench("sick_nav2xx");
    turn(bench, -135, 55);
    bench.send(answer);
    bench.send_sample();
    ASSERT_EQ(bench.scans.size(), 1U);
    for (std::size_t i = 0; i < 55; ++i) {
      const double raw = -135 + 5.0 * static_cast<double>(i);
      const double right = raw - 0.1893 * sine(raw - 21.0503) + 0.0245;
      EXPECT_NEAR(deg_of(bench.scans[0], i, right), right, 5e-5) << raw;
    }
    EXPECT_TRUE(bench.driver->info().warnings.empty());
  }
}

TEST(ColaAngles, OfANav3xxAreCompensatedByEveryFormOfItsAnswer) {
  for (const auto& answer :
       {binary_answer(nav3xx_bytes), text_answer("337 1D8E8D E7"), text_answer("+823 +1937037 +231")}) {
    ColaBench bench("sick_nav31x");
    turn(bench, 0);
    bench.send(answer);
    bench.send_sample();
    ASSERT_EQ(bench.scans.size(), 1U);
    for (std::size_t i = 0; i < 72; ++i) {
      const double raw = 5.0 * static_cast<double>(i);
      const double right =
          180 - (raw + 0.0823 * sine(raw - 193.7037) + 0.0231);  // it counts clockwise, 0 behind
      EXPECT_NEAR(deg_of(bench.scans[0], i, right), right, 5e-5) << raw;
    }
  }
}

TEST(ColaAngles, OfANav3xxAreThoseOfThePrintedTable) {
  constexpr double printed_deg[] = {0.043494, 5.058633, 10.073139};
  // A device may print a negative number of 16 bits with four or with eight digits.
  for (const char* offset : {"FF0B", "FFFFFF0B", "-245"}) {
    ColaBench bench("sick_nav31x");
    turn(bench, 0);
    bench.send(text_answer(std::string("765 FFFCC9B9 ") + offset));
    bench.send_sample();
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_NEAR(deg_of(bench.scans.at(0), i, 180), 180 - printed_deg[i], 5e-5);
  }
}

TEST(ColaAngles, AreThoseOfThePointsAndRaysOfAScan) {
  ColaBench bench("sick_nav2xx");
  turn(bench, -135, 55);
  bench.send(binary_answer(nav2xx_bytes));
  bench.send_sample();
  const PlanarScan& scan = bench.scans.at(0);
  std::vector<CloudPoint> points;
  append_points(scan, points);
  BeamRays rays;
  rays.build(scan, Pose::Identity(), {}, HeightBand());
  ASSERT_EQ(points.size(), 55U);
  for (std::size_t i = 0; i < 55; ++i) {
    const double raw = -135 + 5.0 * static_cast<double>(i);
    const double right = (raw - 0.1893 * sine(raw - 21.0503) + 0.0245) * rad_per_deg;
    EXPECT_NEAR(points[i].x, 10 * std::cos(right), 1e-4);
    EXPECT_NEAR(points[i].y, 10 * std::sin(right), 1e-4);
    EXPECT_NEAR(rays.cosine[i], std::cos(right), 1e-6);
    EXPECT_NEAR(rays.sine[i], std::sin(right), 1e-6);
  }
  EXPECT_TRUE(rays.fits(scan, Pose::Identity()));
  ColaBench raw("sick_nav2xx");
  turn(raw, -135, 55);
  raw.send_sample();
  PlanarScan even = raw.scans.at(0);
  even.angle_min = scan.angle_min;
  EXPECT_FALSE(rays.fits(even, Pose::Identity()));
}

TEST(ColaAngles, StayRawWithASentenceUntilTheAnswerComes) {
  ColaBench bench("sick_nav31x");
  turn(bench, 0);
  bench.send_sample();
  EXPECT_TRUE(bench.has_warning("MCAngleCompSin"));
  EXPECT_NEAR(deg_of(bench.scans.at(0), 1, 175), 175, 5e-5);
  bench.send(binary_answer(nav3xx_bytes));
  bench.send_next();
  EXPECT_FALSE(bench.has_warning("MCAngleCompSin"));
  EXPECT_GT(std::abs(deg_of(bench.scans.at(1), 1, 175) - 175), 0.01);
  EXPECT_EQ(bench.detail("Angle compensation (deg)"), "amplitude 0.0823, phase 193.7037, offset 0.0231");
}

TEST(ColaAngles, OfAnotherScannerAreNotThoseOfTheFormerOne) {
  ColaBench bench("sick_nav31x");
  turn(bench, 0);
  bench.send(binary_answer(nav3xx_bytes), 0, true);
  bench.send_sample();
  // A new connection to the same scanner, without the question: its answer still holds.
  ++bench.sample.telegram_counter;
  bench.send(bench.sample.bytes(bench.dialect), 0, true);
  EXPECT_FALSE(bench.has_warning("MCAngleCompSin"));
  bench.sample.serial = 77;
  bench.send_next();
  EXPECT_TRUE(bench.has_warning("MCAngleCompSin"));
  EXPECT_NEAR(deg_of(bench.scans.back(), 1, 175), 175, 5e-5);
}

TEST(ColaAngles, ADamagedAnswerIsRejectedAndChangesNothing) {
  ColaBench bench("sick_nav31x");
  turn(bench, 0);
  EXPECT_EQ(bench.send(binary_answer(nav3xx_bytes.substr(0, 7))), Reject::size);
  EXPECT_EQ(bench.send(text_answer("+823 +1937037")), Reject::size);
  ColaBench other("sick_nav2xx");
  EXPECT_EQ(other.send(text_answer("FFFFF FFFCC9B9 FFFFFF0B")), Reject::field) << "105 degrees";
  bench.send_sample();
  EXPECT_NEAR(deg_of(bench.scans.at(0), 1, 175), 175, 5e-5);
  EXPECT_TRUE(bench.has_warning("MCAngleCompSin"));
}

TEST(ColaAngles, OfOtherScannersAreLeftAlone) {
  ColaBench bench("sick_lms1xx");
  bench.send(binary_answer(nav2xx_bytes));
  bench.send_sample();
  EXPECT_NEAR(bench.scans.at(0).angle(0), -135 * rad_per_deg, 1e-6);
  EXPECT_TRUE(bench.driver->info().warnings.empty());
}

TEST(ColaAngles, TheDoubtAboutTheZeroOfANav2xxIsSaidOnce) {
  ColaBench bench("sick_nav2xx");
  for (int i = 0; i < 5; ++i) bench.send_next();
  ASSERT_EQ(bench.notes.size(), 1U);
  EXPECT_THAT(bench.notes[0], ::testing::HasSubstr("contradicts itself"));
  EXPECT_EQ(bench.detail("Remark"), bench.notes[0]);
}

}  // namespace
}  // namespace lidard::test
