// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/frames/ring_scan.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "test/core/virtual/small_lidar.h"
#include "test/support/allocations.h"

namespace lidard {
namespace {

constexpr double turn = 2 * M_PI;
constexpr double ring_offset = 0.02;   // rad, of the ring's beam against its column, and
constexpr double ring_delay_s = 9e-6;  // of its firing

/// What a beam in a direction (rad, counter-clockwise from ahead) meets: m, +inf nothing, -inf too near.
using World = std::function<double(double)>;

struct Head {
  double begin = 0;      // azimuth of the first firing, rad clockwise
  double step = 0.0035;  // rad between firings
  double rate = turn * 10;
  double swept = turn;
  double skip_from = 9, skip_to = 9;  // azimuths after `begin` that are not fired
  bool bank_by_bank = false;          // every other column holds ring 1
};

/// A revolution of a lidar with the rings 0 and 1, of which ring 1 sees the world.
Cloud revolution(const World& world, const Head& head = {}, Stamp stamp = Stamp{1'000'000'000}) {
  Cloud cloud;
  cloud.frame_id = "lidar";
  cloud.rings = 2;
  cloud.stamp = stamp;
  std::vector<CloudPoint> points;
  for (double at = 0; at < head.swept - 1e-9; at += head.step) {
    if (at >= head.skip_from && at < head.skip_to) continue;
    const double azimuth = std::fmod(head.begin + at, turn);
    CloudColumn column{};
    column.first_point = static_cast<std::uint32_t>(points.size());
    column.azimuth = static_cast<float>(azimuth);
    column.stamp = stamp + span_from_seconds(at / head.rate);
    points.push_back({0.5F, 0, 1, 99, 0, static_cast<float>(at / head.rate)});
    cloud.columns.push_back(column);
    if (head.bank_by_bank && cloud.columns.size() % 2 == 0) continue;
    const double direction = -(azimuth + ring_offset);
    const double range = world(std::remainder(direction, turn));
    if (std::isfinite(range)) {
      points.push_back({static_cast<float>(range * std::cos(direction)),
                        static_cast<float>(range * std::sin(direction)), -3, 7, 1,
                        static_cast<float>(at / head.rate + ring_delay_s)});
    } else if (range < 0) {
      cloud.too_near.push_back({static_cast<std::uint32_t>(cloud.columns.size() - 1), 1});
    }
  }
  cloud.bank_by_bank = head.bank_by_bank;
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(points.data());
  cloud.points_bytes.assign(bytes, bytes + points.size() * sizeof(CloudPoint));
  cloud.complete = true;
  return cloud;
}

RingScanSpec spec_of(double resolution = 0.007) { return {1, resolution, 0.4, 100}; }

/// A square room of 8 m around the lidar.
double room(double direction) {
  return 4 / std::max(std::fabs(std::cos(direction)), std::fabs(std::sin(direction)));
}

double inf() { return std::numeric_limits<double>::infinity(); }

TEST(RingScan, SeesAWallWhereItIsAtEveryResolutionAndCut) {
  for (const double resolution : {0.001, 0.0035, 0.007, 0.02}) {
    for (const double begin : {0.0, 1.0, M_PI, 5.9}) {
      Head head;
      head.begin = begin;
      RingScan ring(spec_of(resolution));
      PlanarScan scan;
      ASSERT_TRUE(ring.convert(revolution(room, head), scan));
      ASSERT_EQ(violation(scan), nullptr) << violation(scan);
      EXPECT_EQ(scan.beams, static_cast<std::size_t>(std::lround(turn / resolution)));
      EXPECT_EQ(scan.frame_id, "lidar");
      for (std::size_t i = 0; i < scan.beams; ++i) {
        ASSERT_EQ(scan.statuses[i], BeamStatus::hit) << resolution << " " << begin << " beam " << i;
        const double direction = static_cast<double>(scan.angle(i));
        // Only where the walls meet does the line between two returns cut the corner.
        const double corner = std::fabs(std::remainder(direction - M_PI / 4, M_PI / 2));
        ASSERT_NEAR(scan.ranges[i], room(direction), corner < 0.02 ? 0.05 : 1e-4)
            << resolution << " " << begin << " beam " << i;
        ASSERT_EQ(scan.intensities[i], 7);
      }
    }
  }
}

TEST(RingScan, ColumnsOfAnotherBankAreNoBeamsWithoutReturn) {
  Head head;
  head.bank_by_bank = true;
  RingScan ring(spec_of(0.0035));
  PlanarScan scan;
  const auto gate = [](double direction) { return std::fabs(direction) < 0.3 ? inf() : room(direction); };
  ASSERT_TRUE(ring.convert(revolution(gate, head), scan));
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const double from_gate = std::fabs(std::remainder(static_cast<double>(scan.angle(i)), turn)) - 0.3;
    if (std::fabs(from_gate) < 0.02) continue;
    ASSERT_EQ(scan.statuses[i], from_gate > 0 ? BeamStatus::hit : BeamStatus::invalid) << "beam " << i;
  }
}

TEST(RingScan, TurnsWithTheLidarAndItsFirstBeamIsTheFirstRay) {
  Head head;
  head.begin = M_PI;
  RingScan ring(spec_of());
  PlanarScan scan;
  ASSERT_TRUE(ring.convert(revolution(room, head), scan));
  EXPECT_LT(scan.angle_increment, 0);
  EXPECT_NEAR(scan.scan_time, 0.1, 1e-5);
  EXPECT_NEAR(scan.time_increment * static_cast<float>(scan.beams), 0.1, 1e-5);
  // The firing in any beam's direction left at the time that the scan says.
  for (const std::size_t beam : {std::size_t{0}, scan.beams / 3, scan.beams * 9 / 10}) {
    const double azimuth = -static_cast<double>(scan.angle(beam)) - ring_offset - head.begin;
    const double in_turn = azimuth - turn * std::floor(azimuth / turn + 0.005);
    const double fired = 1 + in_turn / head.rate + ring_delay_s;
    const double told =
        seconds(scan.stamp - Stamp{}) + static_cast<double>(scan.time_increment) * static_cast<double>(beam);
    EXPECT_NEAR(told, fired, 3e-6) << beam;
  }
}

TEST(RingScan, KeepsItsAnglesForGood) {
  RingScan ring(spec_of());
  PlanarScan scan;
  Head head;
  ASSERT_TRUE(ring.convert(revolution(room, head), scan));
  const float first = scan.angle_min;
  head.begin = 0.003;
  ASSERT_TRUE(ring.convert(revolution(room, head), scan));
  EXPECT_EQ(scan.angle_min, first);
  head.begin = turn - 0.001;
  ASSERT_TRUE(ring.convert(revolution(room, head), scan));
  EXPECT_EQ(scan.angle_min, first);
  for (std::size_t i = 2; i + 2 < scan.beams; ++i)
    ASSERT_NEAR(scan.ranges[i], room(static_cast<double>(scan.angle(i))), 0.05) << i;
}

TEST(RingScan, TellsNothingThereFromNotObservedFromTooNear) {
  const World world = [](double direction) {
    if (direction > 0 && direction < 1) return inf();
    if (direction > 1 && direction < 1.5) return -inf();
    return 5.0;
  };
  Head head;
  head.skip_from = 3.5;  // clockwise: directions -3.5 - 0.02 = 2.76 ... to -4.52 = 1.76
  head.skip_to = 4.5;
  RingScan ring(spec_of(0.0035));
  PlanarScan scan;
  ASSERT_TRUE(ring.convert(revolution(world, head), scan));
  ASSERT_EQ(violation(scan), nullptr);
  EXPECT_NEAR(scan.scan_time, 0.1, 1e-5);
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const double direction = std::remainder(static_cast<double>(scan.angle(i)), turn);
    const auto inside = [&](double from, double to) {
      return direction > from + 0.01 && direction < to - 0.01;
    };
    const BeamStatus expected = inside(0, 1)         ? BeamStatus::none
                                : inside(1, 1.5)     ? BeamStatus::near
                                : inside(1.77, 2.76) ? BeamStatus::invalid
                                                     : BeamStatus::hit;
    const bool clear = expected != BeamStatus::hit || inside(-3.1, 0) || inside(2.78, 3.1);
    if (clear) {
      ASSERT_EQ(scan.statuses[i], expected) << direction;
    }
  }
}

TEST(RingScan, LosesNoThinPoleToACoarseResolution) {
  for (double pole = -3; pole < 3; pole += 0.0717) {
    const World world = [pole](double direction) {
      return std::fabs(direction - pole) < 0.00176 ? 2.0 : 6.0;
    };
    RingScan ring(spec_of(0.02));
    PlanarScan scan;
    ASSERT_TRUE(ring.convert(revolution(world), scan));
    EXPECT_LT(*std::min_element(scan.ranges.begin(), scan.ranges.end()), 2.01F) << pole;
  }
}

TEST(RingScan, DoesNotConnectANearObjectWithTheWallBehind) {
  const World world = [](double direction) { return std::fabs(direction) < 0.3 ? 2.0 : 6.0; };
  RingScan ring(spec_of(0.0005));
  PlanarScan scan;
  ASSERT_TRUE(ring.convert(revolution(world), scan));
  for (std::size_t i = 0; i < scan.beams; ++i)
    ASSERT_TRUE(scan.ranges[i] < 2.01F || scan.ranges[i] > 5.99F) << scan.ranges[i];
}

TEST(RingScan, TakesTheNearerOfTwoEchoes) {
  const Cloud both =
      test::rings::both_echoes(revolution([](double) { return 5.0; }),
                               revolution([](double direction) { return direction > 0 ? 3.0 : inf(); }));
  RingScan ring(spec_of());
  PlanarScan scan;
  ASSERT_TRUE(ring.convert(both, scan));
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const double direction = std::remainder(static_cast<double>(scan.angle(i)), turn);
    if (std::fabs(direction) < 0.02 || std::fabs(direction) > 3.12) continue;
    ASSERT_NEAR(scan.ranges[i], direction > 0 ? 3 : 5, 0.001) << direction;
  }
}

TEST(RingScan, AFiringOfWhichOnlyTheSecondEchoCameBackIsABeamOfItsOwn) {
  Head head;
  head.bank_by_bank = true;
  const auto ahead = [](double direction) { return std::fabs(direction) < 0.3; };
  const Cloud both = test::rings::both_echoes(
      revolution([&](double direction) { return ahead(direction) ? inf() : 5.0; }, head),
      revolution([&](double direction) { return ahead(direction) ? 3.0 : inf(); }, head));
  RingScan ring(spec_of());
  PlanarScan scan;
  ASSERT_TRUE(ring.convert(both, scan));
  for (std::size_t i = 0; i < scan.beams; ++i) {
    const double direction = std::remainder(static_cast<double>(scan.angle(i)), turn);
    if (std::fabs(std::fabs(direction) - 0.3) < 0.02) continue;
    ASSERT_NEAR(scan.ranges[i], ahead(direction) ? 3 : 5, 0.001) << direction;
  }
}

TEST(RingScan, LeavesRangesOutsideItsLimitsOut) {
  const World world = [](double direction) { return direction > 0 ? 0.3 : 150.0; };
  RingScan ring(spec_of());
  PlanarScan scan;
  ASSERT_TRUE(ring.convert(revolution(world), scan));
  ASSERT_EQ(violation(scan), nullptr);
  EXPECT_EQ(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::hit), 0);
  EXPECT_GT(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::near), 440);
  EXPECT_GT(std::count(scan.statuses.begin(), scan.statuses.end(), BeamStatus::none), 440);
}

TEST(RingScan, RefusesWhatIsNoRevolution) {
  RingScan ring(spec_of());
  PlanarScan scan;
  EXPECT_FALSE(ring.convert(Cloud{}, scan));
  Head head;
  head.swept = head.step;
  EXPECT_FALSE(ring.convert(revolution(room, head), scan));
  Cloud standing = revolution(room);
  for (auto& column : standing.columns) column.azimuth = 1;
  EXPECT_FALSE(ring.convert(standing, scan));
}

TEST(RingScan, AllocatesNothingAfterTheFirstRevolution) {
  RingScan ring(spec_of());
  PlanarScan scan;
  const Cloud cloud = revolution(room);
  ring.convert(cloud, scan);
  const auto before = test::allocations();
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(ring.convert(cloud, scan));
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace lidard
