// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Virtual scans of all that stands between two heights, against worlds whose truth is known.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "test/core/virtual/cut_bench.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

using namespace test::cut;

/// What the nearest thing of a band is, and where the lidar could see it.
class BandTruth {
 public:
  BandTruth(const sim::Yard& yard, const sim::YardLidar& lidar, const Eigen::Vector2d& at, HeightBand band)
      : yard_(yard), lidar_(lidar), at_(at), band_(band) {}

  /// m from the virtual frame's axis; things are at least 5 cm high.
  double distance(double angle) const {
    double nearest = infinite;
    each_height([&](double z) { nearest = std::min(nearest, cast(angle, z)); });
    return nearest;
  }
  /// Nothing stands between the lidar and some part of that thing.
  bool is_visible(double angle, double distance) const {
    bool visible = false;
    each_height([&](double z) {
      if (std::abs(cast(angle, z) - distance) > 0.02) return;
      const Eigen::Vector3d point(at_.x() + (distance - 0.01) * std::cos(angle),
                                  at_.y() + (distance - 0.01) * std::sin(angle), z);
      const Eigen::Vector3d way = point - lidar_.pose.translation();
      const double free = yard_.cast({lidar_.pose.translation(), way.normalized()}, true);
      visible = visible || free > way.norm() - 0.02;
    });
    return visible;
  }

 private:
  template <class Use>
  void each_height(Use use) const {
    const int heights = static_cast<int>((band_.max - band_.min) / 0.05);
    for (int i = 0; i < heights; ++i) use(band_.min + 0.001 + 0.05 * i);
  }
  double cast(double angle, double z) const {
    return yard_.cast({{at_.x(), at_.y(), z}, {std::cos(angle), std::sin(angle), 0}}, false);
  }

  const sim::Yard& yard_;
  const sim::YardLidar& lidar_;
  Eigen::Vector2d at_;
  HeightBand band_;
};

struct Score {
  std::size_t beams = 0, visible = 0, right = 0, phantom = 0, through = 0, free = 0, silent = 0;
  std::size_t hidden_free = 0, hidden_through = 0;  ///< of beams whose truth the lidar cannot see
  double share(std::size_t count) const {
    return 100.0 * static_cast<double>(count) / static_cast<double>(visible);
  }
  std::string text() const {
    char line[200];
    std::snprintf(
        line, sizeof line,
        "visible %.1f %% of %zu: right %.2f phantom %.2f through %.2f free %.2f silent %.2f %%; hidden: "
        "through %zu, free %zu",
        100.0 * static_cast<double>(visible) / static_cast<double>(beams), beams, share(right),
        share(phantom), share(through), share(free), share(silent), hidden_through, hidden_free);
    return line;
  }
};

void judge(const PlanarScan& scan, const BandTruth& truth, double tolerance, Score& score) {
  for (std::size_t beam = 0; beam < scan.beams; ++beam) {
    const double angle = static_cast<double>(scan.angle(beam));
    const double half = static_cast<double>(scan.angle_increment) / 2;
    const double real = truth.distance(angle);
    const BeamStatus status = scan.statuses[beam];
    const auto range = static_cast<double>(scan.ranges[beam]);
    double error = range - real;
    for (const double side : {-half, half}) {
      const double other = range - truth.distance(angle + side);
      if (std::abs(other) < std::abs(error)) error = other;
    }
    ++score.beams;
    if (!truth.is_visible(angle, real)) {
      score.hidden_free += status == BeamStatus::none ? 1 : 0;
      score.hidden_through += status == BeamStatus::hit && error > tolerance ? 1 : 0;
      continue;
    }
    ++score.visible;
    if (status == BeamStatus::none)
      ++score.free;
    else if (status != BeamStatus::hit)
      ++score.silent;
    else if (std::abs(error) <= tolerance)
      ++score.right;
    else
      ++(error < 0 ? score.phantom : score.through);
  }
}

Cut band_cut(HeightBand band) {
  Cut cut;
  cut.settings.mode = CutMode::band;
  cut.settings.how.noise = 0.02;
  cut.band = band;
  cut.frame = make_pose({1.5, 0, 0}, {0, 0, 0});
  return cut;
}

struct Bar {
  const char* name;
  std::size_t yard_case;
  HeightBand band;
  double strict_right, safety_right, most_phantom;  // percent of what the lidar could see
};

class VirtualBandBars : public ::testing::TestWithParam<Bar> {};

/// What is seen through is mostly what no ring met: a block lower than the lowest ring there, or a slab
/// overhead between two rings.
TEST_P(VirtualBandBars, MostOfAYardIsRightAndNothingIsFalselyFree) {
  const Bar& bar = GetParam();
  Score strict, safety;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const sim::YardScene scene = sim::make_yard_scene(sim::yard_cases()[bar.yard_case], seed);
    Cut cut = band_cut(bar.band);
    cut.grid = full_circle(360);
    cut.make(scene.cloud, scene.lidar.pose);
    const BandTruth truth(scene.yard, scene.lidar, {1.5, 0}, bar.band);
    judge(cut.strict, truth, 0.08, strict);
    judge(cut.safety, truth, 0.08, safety);
  }
  RecordProperty("strict", strict.text());
  RecordProperty("safety", safety.text());
  SCOPED_TRACE("strict: " + strict.text() + "\nsafety: " + safety.text());
  EXPECT_GT(strict.visible, strict.beams * 9 / 10);
  EXPECT_GE(strict.share(strict.right), bar.strict_right);
  EXPECT_GE(safety.share(safety.right), bar.safety_right);
  EXPECT_LE(safety.share(safety.phantom), bar.most_phantom);
  EXPECT_LE(strict.share(strict.phantom), bar.most_phantom);
  EXPECT_EQ(strict.free + safety.free + strict.hidden_free + safety.hidden_free, 0U);
}

INSTANTIATE_TEST_SUITE_P(Yards, VirtualBandBars,
                         ::testing::Values(Bar{"of_16_rings_all_heights", 0, {0, 2.5}, 85, 89, 5},
                                           Bar{"of_16_rings_without_ground", 0, {0.1, 1.8}, 92, 95, 2.6},
                                           Bar{"of_16_rings_waist", 0, {0.4, 1.0}, 93, 95, 1},
                                           Bar{"of_32_rings_all_heights", 3, {0, 2.5}, 87, 91, 4.5},
                                           Bar{"of_32_rings_without_ground", 3, {0.1, 1.8}, 94, 97, 1},
                                           Bar{"of_64_rings_without_ground", 5, {0.1, 1.8}, 94, 97, 1}),
                         [](const auto& each) { return std::string(each.param.name); });

TEST(VirtualBand, ABeamOverheadIsInTheBandAndNotInTheSlice) {
  sim::Yard yard;
  yard.objects = {box({8, 0, 2.35}, {1, 6, 0.4}), wall(20, -30, 20, 30)};
  for (const std::size_t rings : {16U, 32U, 64U}) {
    sim::YardLidar lidar = lidar16();
    lidar.elevations = sim::even_rings(rings, -15, 15);
    const Cloud cloud = seen(yard, lidar);
    Cut slice;
    slice.make(cloud, lidar.pose);
    // Straight beneath the lidar, where face and underside lie along the beams, and beside it.
    for (const Eigen::Vector2d& at : {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.6, 0.25)}) {
      Cut band = band_cut({0, 2.5});
      band.settings.how.noise = 0.005;
      band.frame = make_pose({at.x(), at.y(), 0}, {0, 0, 0});
      band.make(cloud, lidar.pose);
      for (int step = -30; step <= 30; ++step) {
        const double angle = step * degree / 2;
        const double ahead = std::cos(slice.grid.angle(slice.grid.nearest(angle)));
        EXPECT_NEAR(slice.range(slice.strict, angle), 20 / ahead, 0.01) << rings << ", " << step;
        EXPECT_NEAR(band.range(band.strict, angle), (7.5 - at.x()) / ahead, 0.02) << rings << ", " << step;
        EXPECT_NEAR(band.range(band.safety, angle), (7.5 - at.x()) / ahead, 0.02) << rings << ", " << step;
      }
    }
  }
}

TEST(VirtualBand, TheGroundIsNoObstacleHoweverLowTheBandBegins) {
  sim::Yard yard;
  yard.objects = {wall(12, -30, 12, 30)};
  sim::Rng rng(4);
  sim::YardLidar lidar = lidar16();
  lidar.noise = 0.02;
  const Cloud cloud = sim::measure(yard, lidar, rng);
  for (const double low : {-0.2, 0.0, 0.05}) {
    Cut cut = band_cut({low, 1.8});
    cut.make(cloud, lidar.pose);
    for (std::size_t beam = 0; beam < cut.grid.beams; ++beam) {
      const double angle = cut.grid.angle(beam);
      const double truth = std::cos(angle) > 0 ? (12 - 1.5) / std::cos(angle) : infinite;
      for (const PlanarScan* scan : {&cut.strict, &cut.safety}) {
        if (scan->statuses[beam] != BeamStatus::hit) continue;
        EXPECT_NEAR(static_cast<double>(scan->ranges[beam]), truth, 0.1 + 0.01 * truth)
            << low << ", " << beam;
      }
    }
    EXPECT_GT(cut.count(cut.safety, BeamStatus::hit), cut.grid.beams / 4);
  }
}

TEST(VirtualBand, WhatStandsInFrontHidesWhatIsBehindAsSeenFromTheVirtualFrame) {
  // The lidar on the roof looks over the crate; the virtual frame near the ground must not.
  sim::Yard yard;
  yard.objects = {box({6, 0, 0.5}, {0.5, 2, 1}), wall(15, -30, 15, 30)};
  for (const HeightBand band : {HeightBand{0.1, 1.8}, HeightBand{1.2, 1.8}}) {
    Cut cut = band_cut(band);
    cut.settings.how.noise = 0.005;
    cut.make(seen(yard, lidar16()), lidar16().pose);
    const bool reaches = band.min < 1;
    for (int angle = -8; angle <= 8; ++angle) {
      const double ahead = std::cos(cut.grid.angle(cut.grid.nearest(angle * degree)));
      const double truth = ((reaches ? 5.75 : 15) - 1.5) / ahead;
      EXPECT_NEAR(cut.range(cut.safety, angle * degree), truth, 0.05) << band.min << ", " << angle;
    }
  }
}

}  // namespace
}  // namespace lidard
