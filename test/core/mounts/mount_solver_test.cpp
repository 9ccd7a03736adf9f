// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/mount_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "core/base/angle.h"
#include "test/core/mounts/parked_trial.h"

namespace lidard {
namespace {

using test::Errors;
using test::Place;
using test::Trial;

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

// As seen by the one that hangs upside down, the others hang upside down: (x, y, yaw) is (x, -y, -yaw).
TEST(MountSolver, AReferenceThatHangsUpsideDownTurnsTheOthersOver) {
  for (const std::size_t reference : {std::size_t{0}, std::size_t{1}, std::size_t{2}}) {
    Trial trial(7);
    trial.make_yard();
    trial.add({0.5, 1, 0.7});
    trial.add({0.5, -1, -0.7}, {}, true);
    trial.add({-0.5, 0.3, 2.5}, {}, true);
    const MountSolution solution = solve_mounts(trial.sensors, reference);
    for (std::size_t i = 0; i < 3; ++i) {
      if (i == reference) continue;
      SCOPED_TRACE(std::to_string(i) + " by " + std::to_string(reference));
      const MountEstimate& found = solution.sensors[i];
      ASSERT_EQ(found.verdict, MountVerdict::found);
      EXPECT_EQ(found.is_mirrored, (i == 0) != (reference == 0));
      PlanarPose truth = trial.truth[reference].inverse() * trial.truth[i];
      if (reference != 0) truth = {truth.x, -truth.y, -truth.yaw};
      const PlanarPose at = trial.sensors[reference].configured.inverse() * found.pose;
      EXPECT_NEAR(at.x, truth.x, 0.005);
      EXPECT_NEAR(at.y, truth.y, 0.005);
      EXPECT_NEAR(std::remainder(at.yaw - truth.yaw, two_pi), 0, 0.001);
    }
  }
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
  verdict_in([](Place& silo) { silo.round({1.5, 0.7}, 8, 720); });
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

TEST(MountSolver, BeforeAnArcThePosesTurnedAboutItsMiddleAreWithinTheDeviation) {
  Trial trial(13);
  const Eigen::Vector2d middle(1.5, 0.7);
  Place circle;
  circle.round(middle, 8, 720);
  for (int i = 0; i < 600; ++i) {  // with gates that narrow, so that only one turn fits
    if (i * i / 12000 % 2 == 0) trial.place.walls.push_back(circle.walls[static_cast<std::size_t>(i)]);
  }
  trial.add({0.5, 1, 1.5}, {}, false, 0.05);
  trial.add({-0.5, -1, 1.2}, {}, false, 0.05);
  const MountSolution solution = solve_mounts(trial.sensors, 0);
  const MountEstimate& estimate = solution.sensors[1];
  ASSERT_EQ(estimate.verdict, MountVerdict::found);
  const Eigen::Vector2d about = trial.sensors[0].configured * (trial.truth[0].inverse() * middle);
  const Eigen::Vector2d arm = Eigen::Vector2d(estimate.pose.x, estimate.pose.y) - about;
  const Eigen::Vector3d turned = rad_per_deg * Eigen::Vector3d(-arm.y(), arm.x(), 1);
  EXPECT_LT(turned.dot(estimate.covariance.inverse() * turned), 1) << "nothing shows a turn by a degree";
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
