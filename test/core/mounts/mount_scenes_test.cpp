// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Places that are hard on `lidard calibrate`: a mount is found, or said not to be, and never written wrong.
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "core/base/angle.h"
#include "core/mounts/mount_solver.h"
#include "test/core/mounts/parked_trial.h"

namespace lidard {
namespace {

using test::Trial;

constexpr double wrong_m = 0.008, wrong_rad = 0.05 * rad_per_deg;

enum class Wanted { found, refused, honest };

struct Scene {
  const char* name;
  Wanted wanted;
  std::function<void(Trial&)> make;
};

void add_two(Trial& trial, double yaw = 0.7) { trial.add({0.5, 1, yaw}), trial.add({0.5, -1, -yaw}); }
void add_rows(Trial& trial, double period, double length, double width, double off_middle) {
  for (double x = -36; x <= 36; x += period) {
    for (const int side : {-1, 1}) trial.place.box({x, side * off_middle}, length, width, 0);
  }
}

/// What was determined must be right, and what was not must be no worse than configured.
void expect_honest(const Trial& trial, const MountEstimate& estimate, const Eigen::Vector3d& error,
                   bool is_found, const std::string& where) {
  for (int c = 0; c < 3; ++c) {
    const double off = std::abs(error[c]), limit = c < 2 ? wrong_m : wrong_rad,
                 sigma = std::sqrt(estimate.covariance(c, c));
    if (!estimate.determined[static_cast<std::size_t>(c)]) {
      EXPECT_FALSE(is_found) << where << ": " << c << " is not determined";
      continue;
    }
    EXPECT_LT(off, is_found ? limit : std::max(limit, 2.5 * sigma)) << where << ": " << c << ", +- " << sigma;
    EXPECT_LT(off, 4 * sigma) << where << ": " << c;
  }
  const PlanarPose truth = trial.sensors[0].configured * (trial.truth[0].inverse() * trial.truth[1]);
  const PlanarPose& configured = trial.sensors[1].configured;
  EXPECT_LT(error.head<2>().norm(), std::hypot(configured.x - truth.x, configured.y - truth.y) + 0.03)
      << where;
}

void check(const std::vector<Scene>& scenes) {
  for (const Scene& scene : scenes) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      Trial trial(100 * seed);
      scene.make(trial);
      if (trial.sensors.empty()) add_two(trial);
      const MountSolution solution = solve_mounts(trial.sensors, 0);
      const MountEstimate& estimate = solution.sensors[1];
      const std::string where = scene.name + (", seed " + std::to_string(seed));
      const bool is_found = estimate.verdict == MountVerdict::found;
      if (scene.wanted == Wanted::found) {
        EXPECT_TRUE(is_found) << where;
      }
      if (scene.wanted == Wanted::refused) {
        EXPECT_FALSE(is_found) << where;
      }
      if (is_found)
        expect_honest(trial, estimate, trial.error(solution, 1), scene.wanted == Wanted::found, where);
      else
        EXPECT_TRUE(estimate.pose.yaw == trial.sensors[1].configured.yaw &&
                    estimate.pose.x == trial.sensors[1].configured.x)
            << where << ": moved";
    }
  }
}

TEST(MountScenes, WhatMovesIsInTheWayOrHangsWrongInAYardDoesNoHarm) {
  const auto yard_with = [](auto more) { return [more](Trial& t) { t.make_yard(), more(t); }; };
  check({
      {"truck that passes", Wanted::found, yard_with([](Trial& t) {
         t.place.box({-8, 5}, 8, 2.4, 0, {{0, 0}, {0, 0}, false, 0.05});
       })},
      {"trucks that creep", Wanted::found, yard_with([](Trial& t) {
         t.place.box({6, 5}, 8, 2.4, 0.1, {{0, 0}, {0, 0}, false, 0.004});
         t.place.box({6, -5}, 8, 2.4, 1.4, {{0, 0}, {0, 0}, false, 0.004});
       })},
      {"truck that leaves", Wanted::found, yard_with([](Trial& t) {
         t.place.box({3, 6}, 8, 2.4, 0, {{0, 0}, {0, 0}, false, 0, 14});
       })},
      {"the vehicle's own body", Wanted::found, yard_with([](Trial& t) {
         t.place.box({-2, 0}, 4, 1.8, 0);
       })},
      {"behind glass", Wanted::honest, yard_with([](Trial& t) {
         t.place.box({0.5, 0}, 10, 9, 0.1, {{0, 0}, {0, 0}, true});
       })},
      {"upside down", Wanted::found, yard_with([](Trial& t) {
         t.add({0.5, 1, 0.7}), t.add({0.5, -1, -0.7}, {}, true);
       })},
      {"half a turn", Wanted::found, yard_with([](Trial& t) {
         add_two(t);
         t.sensors[1].configured.yaw = std::remainder(t.sensors[1].configured.yaw + pi_d, two_pi);
       })},
      {"upside down and half a turn", Wanted::found, yard_with([](Trial& t) {
         t.add({0.5, 1, 0.7}), t.add({0.5, -1, -0.7}, {}, true);
         t.sensors[1].configured.yaw = std::remainder(t.sensors[1].configured.yaw + pi_d, two_pi);
       })},
      {"overlap of 30 degrees", Wanted::honest, yard_with([](Trial& t) {
         t.add({0.5, 0.5, 0}, {}, false, 1, -15, 137.5), t.add({0.5, -0.5, 0}, {}, false, 1, -137.5, 15);
       })},
      {"overlap to one side", Wanted::honest, yard_with([](Trial& t) {
         t.add({0.5, 0.5, 0}, {}, false, 1, -15, 137.5), t.add({-1, -0.5, pi_d}, {}, false, 1, -137.5, 0);
       })},
      {"no overlap", Wanted::refused, yard_with([](Trial& t) {
         t.add({0.5, 0.5, 1.57}, {}, false, 1, -70, 70), t.add({0.5, -0.5, -1.57}, {}, false, 1, -70, 70);
       })},
  });
}

TEST(MountScenes, PlacesThatLookAlikeFartherOnOrTurnedAreNotWrittenWrong) {
  const auto corridor = [](double end) {
    return [end](Trial& t) { t.place.walls = {{{-200, -3}, {200, -3}}, {{-200, 3 - end}, {200, 3 + end}}}; };
  };
  const auto door = [](Trial& t) {
    t.place.walls = {{{-200, -3}, {200, -3}}, {{-200, 3}, {4, 3}}, {{4, 3}, {4, 3.1}},
                     {{4, 3.1}, {5, 3.1}},    {{5, 3.1}, {5, 3}},  {{5, 3}, {200, 3}}};
  };
  const auto walls = [](Trial& t) {
    add_rows(t, 1.2, 0.4, 0.4, 3);
    t.place.walls.push_back({{-60, 5}, {60, 5}}), t.place.walls.push_back({{-60, -5}, {60, -5}});
  };
  check({
      {"corridor one degree off parallel", Wanted::honest, corridor(3.5)},
      {"corridor with a door", Wanted::honest, door},
      {"the same, looking ahead", Wanted::honest, [door](Trial& t) { door(t), add_two(t, 0); }},
      {"colonnade", Wanted::honest, [](Trial& t) { add_rows(t, 1.2, 0.4, 0.4, 3); }},
      {"colonnade, looking ahead", Wanted::honest,
       [](Trial& t) { add_rows(t, 1.2, 0.4, 0.4, 3), add_two(t, 0); }},
      {"fine colonnade", Wanted::honest, [](Trial& t) { add_rows(t, 0.7, 0.4, 0.4, 3); }},
      {"colonnade before walls", Wanted::honest, walls},
      {"the same, looking ahead", Wanted::honest, [walls](Trial& t) { walls(t), add_two(t, 0); }},
      {"shelves", Wanted::honest, [](Trial& t) { add_rows(t, 2, 1.6, 1, 2.5); }},
      {"octagon", Wanted::refused,
       [](Trial& t) {
         t.place.round({0.5, 0.7}, 8, 8);
       }},
      {"round room", Wanted::refused,
       [](Trial& t) {
         t.place.round({1.5, 0.7}, 8, 720);
       }},
      {"rectangle", Wanted::refused,
       [](Trial& t) {
         t.place.box({0.3, 0.4}, 24, 16, 0.2);
       }},
      {"square", Wanted::refused,
       [](Trial& t) {
         t.place.box({0.3, 0.4}, 16, 16, 0.2);
       }},
  });
}

TEST(MountScenes, PlacesThatShowLittleAreRefused) {
  const auto grass = [](double from, double to) {
    return [=](Trial& t) {
      // Each blade stands, and waves by 0.1 m.
      const auto random = std::make_shared<std::mt19937>(t.random());
      std::vector<double> blades(720);
      for (double& blade : blades) blade = t.between(4, 9);
      t.place.grass = [=](double azimuth) {
        const double at = azimuth - two_pi * std::floor(azimuth / two_pi);
        if (at < from || at > to) return 1e9;
        return blades[static_cast<std::size_t>(at / two_pi * 720) % 720] +
               std::normal_distribution<double>(0, 0.1)(*random);
      };
    };
  };
  check({
      {"grass on one side of a yard", Wanted::honest,
       [grass](Trial& t) { grass(0.3, 2.2)(t), t.make_yard(); }},
      {"grass everywhere", Wanted::refused, grass(0, 7)},
      {"a bank", Wanted::refused,
       [](Trial& t) { t.place.grass = [](double a) { return 7 + 0.6 * std::sin(3 * a); }; }},
      {"open field", Wanted::refused, [](Trial&) {}},
      {"one wall", Wanted::refused,
       [](Trial& t) {
         t.place.walls = {{{-20, 6}, {20, 7}}};
       }},
      {"one corner", Wanted::honest,
       [](Trial& t) {
         t.place.walls = {{{-20, 6}, {8, 7}}, {{8, 7}, {9, -20}}};
       }},
      {"one box", Wanted::honest,
       [](Trial& t) {
         t.place.box({6, 1}, 2, 1.5, 0.4);
       }},
      {"the vehicle's own body alone", Wanted::refused,
       [](Trial& t) {
         t.place.box({-2, 0}, 4, 1.8, 0);
       }},
  });
}

}  // namespace
}  // namespace lidard
