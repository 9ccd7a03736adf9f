// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/mount_solver.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "core/base/angle.h"

namespace lidard {
namespace {

using Eigen::Vector2d;

/// Walls seen from above.
struct Place {
  std::vector<std::pair<Vector2d, Vector2d>> walls;

  void box(const Vector2d& centre, double length, double width, double yaw) {
    const Vector2d u = PlanarPose{0, 0, yaw}.turned({length / 2, 0}),
                   v = PlanarPose{0, 0, yaw}.turned({0, width / 2});
    const Vector2d corners[] = {centre + u + v, centre - u + v, centre - u - v, centre + u - v};
    for (int i = 0; i < 4; ++i) walls.emplace_back(corners[i], corners[(i + 1) % 4]);
  }
  double range(const Vector2d& from, double azimuth) const {
    const Vector2d ray(std::cos(azimuth), std::sin(azimuth));
    double nearest = 1e9;
    for (const auto& [a, b] : walls) {
      const Vector2d side = b - a, to = a - from;
      const double across = ray.x() * side.y() - ray.y() * side.x();
      const double range = (to.x() * side.y() - to.y() * side.x()) / across,
                   at = (to.x() * ray.y() - to.y() * ray.x()) / across;
      if (range > 0 && at >= 0 && at <= 1) nearest = std::min(nearest, range);
    }
    return nearest;
  }
};

/// What is wrong with the ranges of a scanner.
struct Errors {
  double noise = 0.01, offset = 0, bias = 0;  // m; the bias is smooth over 10 degrees
};

/// Vehicles parked in places, with mounts that are configured wrong.
struct Trial {
  explicit Trial(unsigned seed) : random(seed) {}
  std::mt19937 random;
  Place place;
  std::vector<PlanarPose> truth;
  std::vector<MountedSensor> sensors;

  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  }
  double normal() { return std::normal_distribution<double>()(random); }
  void make_yard() {
    const double length = between(20, 34), width = between(16, 28);
    place.box({0, 0}, length, width, between(-0.3, 0.3));
    for (int i = 0; i < 12; ++i) {
      const Vector2d centre(between(-length / 2, length / 2), between(-width / 2, width / 2));
      if (centre.norm() > 4) place.box(centre, between(0.4, 3), between(0.4, 3), between(0, 3));
    }
  }
  /// A scanner of 275 degrees; `wrong`: by how much its configured pose is off at most.
  void add(const PlanarPose& at, const Errors& errors = {}, bool upside_down = false, double wrong = 1) {
    const double offset = errors.offset * normal(), phase = between(0, two_pi);
    StillScans scans;
    PlanarScan scan;
    scan.reset(551);
    scan.set_angles(static_cast<float>(-137.5 * rad_per_deg), static_cast<float>(0.5 * rad_per_deg));
    for (int frame = 0; frame < 25; ++frame) {
      for (std::size_t i = 0; i < scan.beams; ++i) {
        const double angle = static_cast<double>(scan.angle(i));
        const double range = place.range({at.x, at.y}, at.yaw + (upside_down ? -angle : angle));
        const double bias = errors.bias * std::sqrt(2.0) * std::sin(angle * 18 + phase);
        if (range > 40)
          scan.set_without_hit(i, BeamStatus::none);
        else
          scan.set_hit(i, static_cast<float>(
                              std::round(1000 * (range + offset + bias + errors.noise * normal())) / 1000));
      }
      scans.add(scan);
    }
    MountedSensor sensor;
    sensor.place.views = scans.views(Eigen::Matrix3d::Identity());
    find_surfaces(sensor.place.views[0], sensor.place.surfaces);
    const double direction = between(0, two_pi), far = wrong * between(0, 0.5);
    sensor.configured = {at.x + far * std::cos(direction), at.y + far * std::sin(direction),
                         at.yaw + wrong * between(-20, 20) * rad_per_deg};
    truth.push_back(at);
    sensors.push_back(sensor);
  }
  void add_three(const Errors& errors = {}) {
    add({0.5, 1, 0.7}, errors);
    add({0.5, -1, -0.7}, errors);
    add({-3, between(-0.5, 0.5), pi_d + between(-0.3, 0.3)}, errors);
  }
  /// Error of a sensor's pose against the reference, in base_frame: m, m, rad.
  Eigen::Vector3d error(const MountSolution& solution, std::size_t i) const {
    const PlanarPose want = sensors[0].configured * (truth[0].inverse() * truth[i]);
    const PlanarPose& got = solution.sensors[i].pose;
    return {got.x - want.x, got.y - want.y, std::remainder(got.yaw - want.yaw, two_pi)};
  }
};

struct Score {
  double across = 0, yaw = 0, normalised = 0, within = 0;  // rms m, rms rad, rms, share within 2.5 deviations
};

/// Random yards; every sensor must be found, or said to be undetermined.
Score score_of(unsigned first_seed, const Errors& errors) {
  Score score;
  double count = 0;
  for (unsigned seed = first_seed; seed < first_seed + 10; ++seed) {
    Trial trial(seed);
    trial.make_yard();
    trial.add_three(errors);
    const MountSolution solution = solve_mounts(trial.sensors, 0);
    for (std::size_t i = 1; i < 3; ++i) {
      const MountEstimate& estimate = solution.sensors[i];
      EXPECT_EQ(estimate.verdict, MountVerdict::found) << seed;
      const Eigen::Vector3d error = trial.error(solution, i);
      EXPECT_LT(error.head<2>().norm(), 0.05) << seed << " sensor " << i << " is in a wrong place";
      score.across += error.head<2>().squaredNorm() / 2, score.yaw += error[2] * error[2], ++count;
      for (int c = 0; c < 3; ++c) {
        const double z = error[c] / std::sqrt(estimate.covariance(c, c));
        score.normalised += z * z / 3, score.within += std::abs(z) < 2.5 ? 1.0 / 3 : 0;
      }
    }
  }
  return {std::sqrt(score.across / count), std::sqrt(score.yaw / count), std::sqrt(score.normalised / count),
          score.within / count};
}

TEST(MountSolver, FindsMountsToTwoMillimetresThroughWhiteNoise) {
  const Score score = score_of(100, {});
  EXPECT_LT(score.across, 0.002);
  EXPECT_LT(score.yaw, 0.02 * rad_per_deg);
  EXPECT_GT(score.normalised, 0.5);
  EXPECT_LT(score.normalised, 1.4);
  EXPECT_GE(score.within, 0.95);
}

TEST(MountSolver, FindsMountsToEightMillimetresThroughOffsetsAndBiasedRanges) {
  const Score score = score_of(200, {0.01, 0.01, 0.005});
  EXPECT_LT(score.across, 0.008);
  EXPECT_LT(score.yaw, 0.05 * rad_per_deg);
  EXPECT_LT(score.normalised, 1.4);
  EXPECT_GE(score.within, 0.95);
}

TEST(MountSolver, AScannerThatHangsUpsideDownIsRecognised) {
  Trial trial(7);
  trial.make_yard();
  trial.add({0.5, 1, 0.7});
  trial.add({0.5, -1, -0.7}, {}, true);
  const MountSolution solution = solve_mounts(trial.sensors, 0);
  ASSERT_EQ(solution.sensors[1].verdict, MountVerdict::found);
  EXPECT_TRUE(solution.sensors[1].is_mirrored);
  EXPECT_LT(trial.error(solution, 1).head<2>().norm(), 0.005);
}

TEST(MountSolver, AScannerThatLooksTheOtherWayIsRecognised) {
  Trial trial(8);
  trial.make_yard();
  trial.add({0.5, 1, 0.7});
  trial.add({0.5, -1, -0.7});
  trial.sensors[1].configured.yaw += pi_d;
  const MountSolution solution = solve_mounts(trial.sensors, 0);
  ASSERT_EQ(solution.sensors[1].verdict, MountVerdict::found);
  EXPECT_LT(trial.error(solution, 1).head<2>().norm(), 0.005);
}

TEST(MountSolver, PlacesThatLookAlikeFromSeveralPosesAreRefused) {
  const auto verdict_in = [](const std::function<void(Place&)>& make) {
    Trial trial(9);
    make(trial.place);
    trial.add_three();
    const MountSolution solution = solve_mounts(trial.sensors, 0);
    for (std::size_t i = 1; i < 3; ++i) {
      EXPECT_EQ(solution.sensors[i].pose.x, trial.sensors[i].configured.x) << "moved";
      EXPECT_NE(solution.sensors[i].verdict, MountVerdict::found);
    }
  };
  verdict_in([](Place& corridor) { corridor.box({0, 0}, 200, 6, 0.1); });
  verdict_in([](Place& rectangle) { rectangle.box({0.3, 0.4}, 24, 16, 0.2); });
  verdict_in([](Place& silo) {
    for (int i = 0; i < 720; ++i) {
      const double a = two_pi * i / 720, b = two_pi * (i + 1) / 720;
      silo.walls.emplace_back(Vector2d(1.5 + 8 * std::cos(a), 0.7 + 8 * std::sin(a)),
                              Vector2d(1.5 + 8 * std::cos(b), 0.7 + 8 * std::sin(b)));
    }
  });
  verdict_in([](Place& /*open field*/) {});
}

TEST(MountSolver, WhereWallsHardlyShowADirectionThePoseStaysAsConfigured) {
  Trial trial(11);
  // Walls one degree off parallel, and no end in sight.
  trial.place.walls = {{{-200, -3}, {200, -3}}, {{-200, 3 - 3.5}, {200, 3 + 3.5}}};
  trial.add({0.5, 0.5, 0.7}, {}, false, 0.05);
  trial.add({0.5, -0.5, -0.7}, {}, false, 0.05);
  const MountSolution solution = solve_mounts(trial.sensors, 0);
  const MountEstimate& estimate = solution.sensors[1];
  EXPECT_FALSE(estimate.determined[0]);
  EXPECT_NEAR(estimate.pose.x, trial.sensors[1].configured.x, 0.02) << "along the walls nothing is known";
}

TEST(MountSolver, AlongACorridorThatIsConfiguredNearlyRightNothingIsChanged) {
  Trial trial(10);
  trial.place.box({0, 0}, 200, 6, 0.1);
  trial.add({0.5, 1, 0.7}, {}, false, 0.05);
  trial.add({0.5, -1, -0.7}, {}, false, 0.05);
  const MountSolution solution = solve_mounts(trial.sensors, 0);
  const MountEstimate& estimate = solution.sensors[1];
  EXPECT_TRUE(estimate.verdict != MountVerdict::found || !estimate.determined[0]);
}

}  // namespace
}  // namespace lidard
