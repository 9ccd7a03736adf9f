// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/drive_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iostream>

#include "core/base/angle.h"
#include "test/sim/world/flat_world.h"

namespace lidard {
namespace {

using Eigen::Vector2d;
using sim::Pose2;

PlanarPose planar(const Pose2& place) { return {place.x, place.y, place.yaw}; }

/// How a vehicle drives: speed (m/s) and turn rate (rad/s) at a time.
using Drive = std::function<Vector2d(double)>;

/// A vehicle with two scanners drives through a yard, with odometry that is wrong by 1 % and walks by 2 mm
/// and 0.1 degrees in 1 m.
struct DriveTrial {
  explicit DriveTrial(unsigned seed) : random(seed) { make_yard(); }
  sim::Rng random;
  sim::FlatWorld yard;
  std::vector<sim::Twist> legs;
  std::vector<OdometryPose> odometry;
  std::vector<PlanarPose> truth;
  std::vector<double> offsets;
  std::vector<DrivenSensor> sensors;

  void make_yard() {
    yard.add_box({0, 0}, {random.within(4) + 15, random.within(3) + 12}, random.within(0.3));
    for (int i = 0; i < 14; ++i) {
      const Vector2d centre(random.within(13), random.within(10));
      yard.add_box(centre, {0.8 + random.within(0.6), 0.8 + random.within(0.6)}, random.within(1.5));
    }
  }
  void drive(const Drive& drive, double seconds = 60) {
    constexpr double leg = 0.05, odometry_step = 0.02;
    for (double t = 0; t < seconds; t += leg) {
      const Vector2d now = drive(t);
      legs.push_back({leg, now.x(), now.y()});
    }
    const sim::Trajectory path({-2, -3, 0.3}, legs);
    PlanarPose place;
    for (double t = 0; t < seconds; t += odometry_step) {
      odometry.push_back({t, place});
      const PlanarPose step = planar(path.at(t)).inverse() * planar(path.at(t + odometry_step));
      const double way = std::sqrt(std::hypot(step.x, step.y));
      place = place * PlanarPose{1.01 * step.x + 0.002 * way * random.gaussian(),
                                 1.01 * step.y + 0.002 * way * random.gaussian(),
                                 step.yaw + 0.1 * rad_per_deg * way * random.gaussian()};
    }
  }
  /// A scanner of 33 Hz whose stamps are `late`, s; its configured pose is wrong.
  void add(const PlanarPose& at, double late, bool is_held = false) {
    const sim::Trajectory path({-2, -3, 0.3}, legs);
    sim::FlatScanner scanner;
    scanner.at = {at.x, at.y}, scanner.yaw = at.yaw, scanner.increment = 0.5 * rad_per_deg;
    scanner.noise = 0.01, scanner.range_max = 40;
    DrivenSensor sensor;
    PlanarScan scan;
    for (double t = 0.1; t < odometry.back().time; t += keyframe_s) {
      const double begin = t + 0.03 * random.uniform();
      const auto later = [](std::size_t i) { return 0.02 * static_cast<double>(i) / 540; };
      scanner.measure(
          yard, [&](std::size_t i) { return path.at(begin + later(i)); }, random, scan);
      DriveSweep sweep{begin + late, scanner.increment, {}};
      for (std::size_t i = 0; i < scan.beams; ++i) {
        if (scan.statuses[i] != BeamStatus::hit) continue;
        const float angle = scan.angle(i), range = scan.ranges[i];
        sweep.returns.push_back(
            {{range * std::cos(angle), range * std::sin(angle), 0}, static_cast<float>(later(i)), 0});
      }
      // Every other scanner counts its beams down: its later returns come first.
      if (sensors.size() % 2 == 1) std::reverse(sweep.returns.begin(), sweep.returns.end());
      sensor.sweeps.push_back(sweep);
    }
    sensor.held_by = is_held ? 0 : sensors.size();
    sensor.configured = {at.x + random.within(0.2), at.y + random.within(0.2), at.yaw + random.within(0.15)};
    if (is_held) sensor.configured = sensors[0].configured * (truth[0].inverse() * at);
    truth.push_back(at), offsets.push_back(-late), sensors.push_back(sensor);
  }
  Eigen::Vector4d error(const DriveSolution& solution, std::size_t i) const {
    const DriveEstimate& got = solution.sensors[i];
    return {got.pose.x - truth[i].x, got.pose.y - truth[i].y,
            std::remainder(got.pose.yaw - truth[i].yaw, two_pi), got.time_offset - offsets[i]};
  }
};

Vector2d winding(double t) { return {1.2, 0.3 * (t < 30 ? 1 : -1) + 0.5 * std::sin(t)}; }

/// Errors of solutions against what they state.
struct Tally {
  Eigen::Vector4d square = Eigen::Vector4d::Zero(), normalised = Eigen::Vector4d::Zero();
  double within = 0, count = 0, scale = 0;

  void add(const DriveTrial& trial, const DriveSolution& solution) {
    for (std::size_t i = 0; i < trial.sensors.size(); ++i) {
      const DriveEstimate& estimate = solution.sensors[i];
      for (const bool known : estimate.determined) EXPECT_TRUE(known);
      const Eigen::Vector4d error = trial.error(solution, i),
                            z = error.cwiseQuotient(estimate.covariance.diagonal().cwiseSqrt());
      EXPECT_LT(error.head<2>().norm(), 0.005);
      EXPECT_LT(std::abs(error[2]), 0.05 * rad_per_deg);
      square += error.cwiseAbs2(), normalised += z.cwiseAbs2();
      within += static_cast<double>((z.array().abs() < 2.5).count()) / 4, ++count;
    }
    const double z = (solution.scale - 1 / 1.01) / solution.scale_sigma;
    scale += z * z * static_cast<double>(trial.sensors.size());
  }
  void judge() const {
    const Eigen::Vector4d rms = (square / count).cwiseSqrt(), z = (normalised / count).cwiseSqrt();
    std::cout << "rms " << 1000 * rms[0] << " and " << 1000 * rms[1] << " mm, " << rms[2] * deg_per_rad
              << " deg, " << 1000 * rms[3] << " ms; normalised " << z.transpose() << ", scale "
              << std::sqrt(scale / count) << "; within 2.5 deviations " << within / count << '\n';
    EXPECT_LT(rms[3], 0.001);
    for (const double one : {z[0], z[1], z[2], z[3], std::sqrt(scale / count)}) {
      EXPECT_GT(one, 0.5);
      EXPECT_LT(one, 1.4);
    }
    EXPECT_GE(within / count, 0.95);
  }
};

TEST(DriveFit, BasePosesAndTimeOffsetsOfADriveAreTrueWithinTheirDeviations) {
  Tally tally;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    DriveTrial trial(seed);
    trial.drive(winding);
    trial.add({0.5, 1, 0.7}, 0.012 - 0.001 * seed);
    trial.add({0.4, -1, -0.8}, -0.02);
    tally.add(trial, solve_drive(trial.odometry, trial.sensors));
  }
  tally.judge();
}

TEST(DriveFit, ASensorThatIsHeldKeepsItsPlaceAgainstTheReference) {
  Tally tally;
  for (unsigned seed = 31; seed < 39; ++seed) {
    DriveTrial trial(seed);
    trial.drive(winding);
    trial.add({0.5, 1, 0.7}, 0.01);
    trial.add({-3, -1, -2.4}, 0.02, true);
    const DriveSolution solution = solve_drive(trial.odometry, trial.sensors);
    const PlanarPose apart = solution.sensors[0].pose.inverse() * solution.sensors[1].pose,
                     want = trial.truth[0].inverse() * trial.truth[1];
    EXPECT_NEAR(apart.x, want.x, 1e-9);
    EXPECT_NEAR(apart.y, want.y, 1e-9);
    tally.add(trial, solution);
  }
  tally.judge();
}

/// Solves a drive that does not show everything; nothing of it may be changed.
DriveSolution solve_one_sided(unsigned seed, const Drive& drive, const std::array<bool, 4>& shown) {
  DriveTrial trial(seed);
  trial.drive(drive);
  trial.add({0.5, 1, 0.7}, 0.012);
  const DriveSolution solution = solve_drive(trial.odometry, trial.sensors);
  const DriveEstimate& estimate = solution.sensors[0];
  const PlanarPose& configured = trial.sensors[0].configured;
  EXPECT_EQ(estimate.determined, shown) << seed;
  // What is not shown stays.
  EXPECT_TRUE(shown[0] || (estimate.pose.x == configured.x && estimate.pose.y == configured.y)) << seed;
  EXPECT_TRUE(shown[2] || estimate.pose.yaw == configured.yaw) << seed;
  EXPECT_TRUE(shown[3] || estimate.time_offset == 0) << seed;
  EXPECT_TRUE(!shown[2] || std::abs(trial.error(solution, 0)[2]) < 0.1 * rad_per_deg) << seed;
  return solution;
}

TEST(DriveFit, AConstantCircleShowsNothing) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    solve_one_sided(seed, [](double) { return Vector2d(1.2, 0.4); }, {false, false, false, false});
    solve_one_sided(seed, [](double) { return Vector2d(0.7, -0.25); }, {false, false, false, false});
  }
}

TEST(DriveFit, AStraightDriveShowsYawAlone) {
  for (unsigned seed = 1; seed <= 5; ++seed)
    solve_one_sided(seed, [](double) { return Vector2d(0.2, 0); }, {false, false, true, false});
}

TEST(DriveFit, AVehicleThatStandsShowsNothing) {
  solve_one_sided(1, [](double) { return Vector2d(0, 0); }, {false, false, false, false});
}

}  // namespace
}  // namespace lidard
