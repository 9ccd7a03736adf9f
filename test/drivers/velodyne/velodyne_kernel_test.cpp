// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/frames/cloud.h"
#include "drivers/velodyne/calibration.h"
#include "drivers/velodyne/models.h"
#include "drivers/velodyne/packet.h"
#include "drivers/velodyne/unpacker.h"
#include "test/drivers/velodyne/calibrated_point.h"

namespace lidard::velodyne {
namespace {

/// A calibration with every term, different for every laser.
Calibration calibration_of(const ModelRow& row, std::mt19937& random, CalibrationModel model) {
  std::uniform_real_distribution<double> some(-1, 1);
  Calibration calibration;
  calibration.model = model;
  calibration.distance_step_m = row.distance_step_m;
  for (std::size_t k = 0; k < row.lasers; ++k) {
    LaserCalibration laser;
    laser.rot_correction = 0.1 * some(random);
    laser.vert_correction = 0.4 * some(random);
    laser.dist_correction = some(random);
    laser.dist_correction_x = some(random);
    laser.dist_correction_y = some(random);
    laser.vert_offset = 0.2 * some(random);
    laser.horiz_offset = 0.03 * some(random);
    laser.two_point = k % 3 == 0 ? TwoPoint::off : TwoPoint::on;
    laser.focal_distance = 10 + some(random);
    laser.focal_slope = 1 + some(random);
    laser.min_intensity = 20;
    laser.max_intensity = 200;
    calibration.lasers.push_back(laser);
  }
  return calibration;
}

/// The slots of some firing sequences; every fourth is empty.
std::vector<std::uint8_t> random_slots(std::mt19937& random) {
  std::vector<std::uint8_t> bytes(packet_size);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
  for (std::size_t slot = 0; slot < 384; ++slot) {
    if (random() % 4 == 0) bytes[3 * slot] = bytes[3 * slot + 1] = 0;
  }
  return bytes;
}

/// What one kind of kernels makes of sequences at many azimuths and turning rates.
PointBytes unpack(const ModelRow& row, const Calibration* calibration, const SequenceKernels& kernels,
                  std::mt19937 random) {
  Unpacker unpacker(row, false, 5, 120, calibration, kernels);
  Cloud cloud;
  std::size_t points = 0;
  for (int i = 0; i < 60; ++i) {
    const auto slots = random_slots(random);
    unpacker.set_rate(i % 20 * 360.0);
    unpacker.reserve_packet(cloud);
    Sequence sequence{};
    for (std::size_t bank = 0; bank < row.banks; ++bank) sequence.slots[bank] = slots.data() + 96 * bank;
    sequence.azimuth_deg = 6.1 * i;
    sequence.in_frame = std::chrono::microseconds(1663 * i);
    unpacker.append(sequence, cloud);
    unpacker.transform(cloud, points);
  }
  cloud.points_bytes.resize(points * point_step);
  return cloud.points_bytes;
}

TEST(VelodyneKernels, EveryProcessorGetsTheSameBytes) {
  if (avx2_kernels() == nullptr || &best_kernels() != avx2_kernels())
    GTEST_SKIP() << "this processor has no other kernels";
  std::mt19937 random(7);
  for (const ModelRow* row : model_rows()) {
    for (const CalibrationModel model : {CalibrationModel::exact, CalibrationModel::ros_drivers}) {
      const Calibration calibration = calibration_of(*row, random, model);
      const auto plain = unpack(*row, nullptr, portable_kernels(), random);
      EXPECT_GT(plain.size(), 60 * row->lasers / 4 * point_step) << row->product;
      EXPECT_TRUE(plain == unpack(*row, nullptr, *avx2_kernels(), random)) << row->product;
      const auto calibrated = unpack(*row, &calibration, portable_kernels(), random);
      EXPECT_GT(calibrated.size(), 60 * row->lasers / 4 * point_step) << row->product;
      EXPECT_TRUE(calibrated == unpack(*row, &calibration, *avx2_kernels(), random)) << row->product;
    }
  }
}

/// Unpacks one sequence and compares every point with the equations, laser by laser.
void expect_equations(const ModelRow& row, const Calibration& calibration, double max_error_m) {
  std::mt19937 random(11);
  const auto slots = random_slots(random);
  const CalibratedGeometry geometry(calibration);
  const Timing& timing = row.timings.front();
  constexpr double rate = 3600;
  constexpr double azimuth = 211.37;
  Unpacker unpacker(row, false, 0, 0, &calibration);
  unpacker.set_rate(rate);
  Cloud cloud;
  std::size_t points = 0;
  unpacker.reserve_packet(cloud);
  Sequence sequence{};
  for (std::size_t bank = 0; bank < row.banks; ++bank) sequence.slots[bank] = slots.data() + 96 * bank;
  sequence.azimuth_deg = azimuth;
  unpacker.append(sequence, cloud);
  unpacker.transform(cloud, points);
  std::size_t next = 0;
  for (std::size_t k = 0; k < row.lasers; ++k) {
    const std::uint8_t* slot = slots.data() + 3 * k;
    const auto count = static_cast<std::uint16_t>(slot[0] | slot[1] << 8);
    if (count == 0) continue;
    ASSERT_LT(next, points);
    const CloudPoint point = cloud.points()[next++];
    // The azimuth of an HDL-64E S1 holds for its whole block.
    const Span turning = row.bank_by_bank ? Span(0) : row.firing_time(timing, k) + timing.before;
    const double at = (azimuth + rate * seconds(turning)) * rad_per_deg;
    const CalibratedPoint expected = place(geometry, k, count, slot[2], std::cos(at), std::sin(at));
    ASSERT_NEAR(point.x, expected.x, max_error_m) << row.product << k;
    ASSERT_NEAR(point.y, expected.y, max_error_m) << row.product << k;
    ASSERT_NEAR(point.z, expected.z, max_error_m) << row.product << k;
    ASSERT_NEAR(point.intensity, expected.intensity, 1e-3) << row.product << k;
  }
  EXPECT_EQ(next, points);
}

TEST(VelodyneKernels, CalibratedReturnsFollowTheEquations) {
  std::mt19937 random(5);
  for (const ModelRow* row : model_rows()) {
    for (const CalibrationModel model : {CalibrationModel::exact, CalibrationModel::ros_drivers})
      expect_equations(*row, calibration_of(*row, random, model), 8e-5);
  }
}

TEST(VelodyneKernels, CalibrationOfAnglesHeightsAndDistancesTakesTheQuickWay) {
  std::mt19937 random(5);
  for (const ModelRow* row : model_rows()) {
    for (const CalibrationModel model : {CalibrationModel::exact, CalibrationModel::ros_drivers}) {
      Calibration calibration = calibration_of(*row, random, model);
      for (LaserCalibration& laser : calibration.lasers) {
        laser.horiz_offset = laser.focal_slope = 0;
        laser.two_point = TwoPoint::off;
        laser.min_intensity = 0;
        laser.max_intensity = 255;
      }
      ASSERT_TRUE(CalibratedGeometry(calibration).terms(0).is_straight());
      expect_equations(*row, calibration, 8e-5);  // in float, up to 262 m away
    }
  }
}

TEST(VelodyneKernels, RangeLimitsTestTheCorrectedDistance) {
  const ModelRow& row = *model_rows().front();
  Calibration calibration;
  calibration.lasers.resize(row.lasers);
  for (std::size_t k = 0; k < row.lasers; ++k)
    calibration.lasers[k].dist_correction = 0.1 * static_cast<double>(k);
  Unpacker unpacker(row, false, 2, 3, &calibration);
  for (int count = 1; count < 2000; ++count) {
    std::vector<std::uint8_t> slots(packet_size);
    for (std::size_t k = 0; k < row.lasers; ++k) {
      slots[3 * k] = static_cast<std::uint8_t>(count);
      slots[3 * k + 1] = static_cast<std::uint8_t>(count >> 8);
    }
    Cloud cloud;
    std::size_t points = 0;
    unpacker.reserve_packet(cloud);
    Sequence sequence{};
    sequence.slots[0] = slots.data();
    unpacker.append(sequence, cloud);
    unpacker.transform(cloud, points);
    std::size_t expected = 0;
    for (std::size_t k = 0; k < row.lasers; ++k) {
      const double distance = count * 0.002 + calibration.lasers[k].dist_correction;
      expected += distance > 2 - 1e-9 && distance < 3 + 1e-9 ? 1U : 0U;
    }
    ASSERT_EQ(points, expected) << count;
  }
}

TEST(VelodyneKernels, AReturnLiesInItsDirectionAtEveryAngle) {
  const ModelRow& row = *model_rows().front();
  Calibration calibration = table_of(row);
  for (LaserCalibration& laser : calibration.lasers) laser = {};
  Unpacker unpacker(row, false, 0, 0, &calibration);
  unpacker.set_rate(0);
  const std::vector<std::uint8_t> slots(packet_size, 0xFF);
  Cloud cloud;
  for (int i = -35990; i <= 35990; ++i) {
    Sequence sequence{};
    sequence.slots.fill(slots.data());
    sequence.azimuth_deg = 0.0100003 * i;
    std::size_t points = 0;
    cloud.clear();
    unpacker.reserve_packet(cloud);
    unpacker.append(sequence, cloud);
    unpacker.transform(cloud, points);
    const double far = 65535 * calibration.distance_step_m;
    const CloudPoint point = cloud.points()[0];
    ASSERT_NEAR(point.x / far, std::cos(sequence.azimuth_deg * rad_per_deg), 2.5e-7) << i;
    ASSERT_NEAR(point.y / far, -std::sin(sequence.azimuth_deg * rad_per_deg), 2.5e-7) << i;
  }
}

}  // namespace
}  // namespace lidard::velodyne
