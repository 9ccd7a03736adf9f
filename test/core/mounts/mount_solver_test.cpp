// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "core/mounts/mount_solver.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "core/base/angle.h"
#include "test/core/mounts/parked_trial.h"

namespace lidard {
namespace {

using Eigen::Vector2d;
using test::Errors;
using test::Place;
using test::Trial;

/// Errors of poses against what is stated of them.
struct Score {
  double across = 0, yaw = 0, normalised = 0, within = 0;  // rms m, rms rad, rms, share within 2.5 deviations
  double found = 0, all = 0;

  void add(const Trial& trial, const std::string& where) {
    const MountSolution solution = solve_mounts(trial.sensors, 0);
    for (std::size_t i = 1; i < trial.sensors.size(); ++i) {
      const MountEstimate& estimate = solution.sensors[i];
      ++all;
      if (estimate.verdict != MountVerdict::found || !estimate.free.empty()) continue;
      const Eigen::Vector3d error = trial.error(solution, i);
      EXPECT_LT(error.head<2>().norm(), 0.05) << where << ": sensor " << i << " is in a wrong place";
      across += error.head<2>().squaredNorm() / 2, yaw += error[2] * error[2], ++found;
      for (int c = 0; c < 3; ++c) {
        const double z = error[c] / std::sqrt(estimate.covariance(c, c));
        normalised += z * z / 3, within += std::abs(z) < 2.5 ? 1.0 / 3 : 0;
      }
    }
  }
  Score mean() const {
    return {std::sqrt(across / found),
            std::sqrt(yaw / found),
            std::sqrt(normalised / found),
            within / found,
            found,
            all};
  }
};

/// Random yards, in which every sensor must be found.
Score score_of(unsigned first_seed, const Errors& errors) {
  Score score;
  for (unsigned seed = first_seed; seed < first_seed + 10; ++seed) {
    Trial trial(seed);
    trial.make_yard();
    trial.add_three(errors);
    score.add(trial, std::to_string(seed));
  }
  EXPECT_EQ(score.found, score.all);
  return score.mean();
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

void add_boxes(Trial& trial, int count, double half_length, double half_width, double least, double most) {
  for (int i = 0; i < count; ++i) {
    const Vector2d centre(trial.between(-half_length, half_length), trial.between(-half_width, half_width));
    if (centre.norm() > 3 + most / 2)
      trial.place.box(centre, trial.between(least, most), trial.between(least, most), trial.between(0, 3));
  }
}
void make_hall(Trial& trial) {
  trial.place.box({trial.between(-2, 2), trial.between(-2, 2)}, trial.between(12, 18), trial.between(8, 12),
                  trial.between(-0.3, 0.3));
  add_boxes(trial, 4, 7, 5, 0.5, 2);
}
void make_street(Trial& trial) {
  for (const int side : {-1, 1}) {
    const double wall = trial.between(5, 8);
    trial.place.walls.push_back({{-60, side * wall}, {60, side * (wall + trial.between(-1, 1))}});
    for (double x = -25; x < 25; x += trial.between(5, 9))
      trial.place.box({x, side * (wall - 2 + trial.between(-0.3, 0.3))}, trial.between(4, 5), 1.8,
                      trial.between(-0.06, 0.06));
  }
}
void make_field(Trial& trial) { add_boxes(trial, 16, 12, 12, 0.8, 3); }
void make_dock(Trial& trial) {
  trial.place.walls = {{{6, -20}, {7, 20}}};
  for (double y = -15; y < 15; y += trial.between(3, 5))
    trial.place.box({6.3, y}, trial.between(0.5, 2), trial.between(0.6, 1.5), trial.between(-0.1, 0.1));
  trial.place.box({-7, trial.between(2, 5)}, 8, 2.4, trial.between(-0.2, 0.2));
  trial.place.box({0, -8}, trial.between(3, 8), 2.4, trial.between(-0.5, 0.5));
}

// Offsets and errors that depend on range, incidence, surface and neighbouring beams, steps of the ranges and
// mixed pixels, as data sheets of safety scanners (few mm) and of others (30 mm at most) have them.
TEST(MountSolver, DeviationsAreTrueForTheKindsOfErrorsThatScannersHave) {
  Errors good, usual;
  good.noise = 0.004, good.offset = 0.003, good.spot = 0.008;
  good.by_range = good.swing = good.slant = 0.001, good.dark = 0.003;
  usual.noise = 0.012, usual.offset = 0.017, usual.spot = 0.01, usual.step = 0.004, usual.bias = 0.002;
  usual.by_range = 0.005, usual.swing = 0.004, usual.slant = 0.003, usual.dark = 0.01;
  const std::vector<std::pair<const char*, std::function<void(Trial&)>>> places{
      {"yard", [](Trial& trial) { trial.make_yard(); }},
      {"hall", make_hall},
      {"street", make_street},
      {"boxes in a field", make_field},
      {"dock", make_dock}};
  const auto judge = [](const Score& score, const std::string& name) {
    const Score mean = score.mean();
    std::cout << name << ": " << mean.found << " of " << mean.all << " found, error " << 1000 * mean.across
              << " mm, " << mean.yaw * deg_per_rad << " deg; " << mean.normalised << " of what is stated, "
              << mean.within << " within 2.5\n";
    EXPECT_GE(mean.found, mean.all / 4) << name;
    EXPECT_GT(mean.normalised, 0.5) << name;
    EXPECT_LT(mean.normalised, 1.4) << name;
  };
  for (const Errors& errors : {good, usual}) {
    Score with_roof;
    for (const auto& [name, make] : places) {
      Score score;
      const auto trial_of = [&, make = make](unsigned seed) {
        Trial trial(1000 + seed);
        make(trial);
        for (test::Wall& wall : trial.place.walls) wall.dark = trial.between(0, 1);
        return trial;
      };
      for (unsigned seed = 1; seed <= 16; ++seed) {
        Trial trial = trial_of(seed);
        trial.add_three(errors);
        score.add(trial, name + (", seed " + std::to_string(seed)));
      }
      judge(score, name);
      for (unsigned seed = 21; seed <= 24; ++seed) {
        Trial trial = trial_of(seed);
        trial.add({0.5, 1, 0.7}, errors), trial.add({0.5, -1, -0.7}, errors);
        trial.add_roof({-0.5, 0, 0.1}, errors);
        with_roof.add(trial, name + (" with roof, seed " + std::to_string(seed)));
      }
    }
    judge(with_roof, "with a multi-plane lidar");
  }
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

TEST(MountSolver, AcrossACorridorMountsAreFoundAndAlongItTheyStayAsConfigured) {
  for (const double yaw : {0.0, 0.1}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      SCOPED_TRACE(std::to_string(yaw) + ", seed " + std::to_string(seed));
      Trial trial(seed);
      trial.place.box({0, 0.3}, 200, 6, yaw);
      trial.add({0.5, 1, 0.7}, {0.01, 0.005});
      trial.add({0.5, -1, -0.7}, {0.01, 0.005});
      const MountSolution solution = solve_mounts(trial.sensors, 0);
      const MountEstimate& found = solution.sensors[1];
      const PlanarPose& configured = trial.sensors[1].configured;
      ASSERT_EQ(found.verdict, MountVerdict::found);
      ASSERT_EQ(found.free.size(), 1U);
      EXPECT_FALSE(found.free[0].turn);
      // The corridor as the reference, which stays as it is configured, sees it.
      const Vector2d along =
          trial.sensors[0].configured.turned(trial.truth[0].inverse().turned({std::cos(yaw), std::sin(yaw)}));
      EXPECT_GT(std::abs(found.free[0].shift.dot(along)), 0.9999);
      const Eigen::Vector3d error = trial.error(solution, 1);
      EXPECT_LT(std::abs(along.x() * error.y() - along.y() * error.x()), 0.006);
      EXPECT_LT(std::abs(error[2]), 0.05 * rad_per_deg);
      EXPECT_NEAR(along.dot(Vector2d(found.pose.x - configured.x, found.pose.y - configured.y)), 0, 0.003);
      EXPECT_TRUE(found.determined[2]);
      EXPECT_FALSE(found.determined[std::abs(along.x()) > std::abs(along.y()) ? 0 : 1]);
    }
  }
}

TEST(MountSolver, AScannerThatHangsUpsideDownInACorridorIsNotPlacedWrong) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    Trial trial(seed);
    trial.place.box({0, 0.3}, 200, 6, 0);
    trial.add({0.5, 1, 0.7}, {}, false, 0.2);
    trial.add({0.5, -1, -0.7}, {}, true, 0.2);
    const MountEstimate estimate = solve_mounts(trial.sensors, 0).sensors[1];
    EXPECT_NE(estimate.verdict, MountVerdict::found) << seed;
  }
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
