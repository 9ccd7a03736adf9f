// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/virtual/virtualizer.h"
#include "test/core/virtual/cut_bench.h"

namespace lidard {
namespace {

using namespace test::cut;

/// The cloud as another driver's topic has it: no columns, in any order.
Cloud as_topic(const Cloud& cloud, std::uint64_t seed) {
  Cloud topic = cloud;
  topic.columns.clear();
  sim::Rng rng(seed);
  // Ring by ring, as organised messages stand.
  std::stable_sort(topic.points(), topic.points() + topic.size(),
                   [](const CloudPoint& a, const CloudPoint& b) { return a.ring < b.ring; });
  return topic;
}

TEST(Virtualizer, TopicCloudsWithRingsGiveTheSameScan) {
  sim::Yard yard;
  yard.objects = {wall(10, -30, 10, 30), wall(-14, -30, -14, 30)};
  const Cloud cloud = seen(yard, lidar16());
  Cut known, topic;
  known.make(cloud, lidar16().pose);
  topic.make(as_topic(cloud, 1), lidar16().pose);
  for (double angle = -40; angle <= 40; angle += 1)
    EXPECT_NEAR(topic.range(topic.strict, angle * degree), known.range(known.strict, angle * degree), 0.005);
  EXPECT_NEAR(topic.range(topic.strict, pi_d), 14, 0.005);
}

TEST(Virtualizer, RingsAreFoundByTheirElevations) {
  sim::Yard yard;
  yard.objects = {wall(10, -30, 10, 30)};
  Cloud cloud = as_topic(seen(yard, lidar16()), 1);
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.points()[i].ring = 0;
  cloud.rings = 1;
  Cut cut;
  cut.make(cloud, lidar16().pose);
  EXPECT_NEAR(cut.range(cut.strict, 0.2), 10 / std::cos(cut.grid.angle(cut.grid.nearest(0.2))), 0.01);
}

TEST(Virtualizer, ACloudWithoutRingsIsPointsAloneAndProvesNothing) {
  Cloud cloud;
  cloud.stamp = Stamp{1'000'000'000};
  cloud.rings = 1;
  sim::Rng rng(3);
  std::vector<CloudPoint> points;
  for (int i = 0; i < 5000; ++i) {
    const double a = rng.uniform() * 2 * pi_d;
    const double z = (rng.uniform() - 0.5) * 4;
    points.push_back({static_cast<float>(9 * std::cos(a)), static_cast<float>(9 * std::sin(a)),
                      static_cast<float>(z), 1, 0, 0});
  }
  cloud.points_bytes.resize(points.size() * sizeof(CloudPoint));
  std::copy(points.begin(), points.end(), cloud.points());
  Cut cut;
  cut.band = {-0.1, 0.1};
  cut.frame = make_pose({0, 0, 2}, {0, 0, 0});
  cut.make(cloud, lidar16().pose);
  EXPECT_EQ(cut.count(cut.strict, BeamStatus::invalid), cut.grid.beams);
  EXPECT_GT(cut.count(cut.safety, BeamStatus::hit), 100U);
  EXPECT_EQ(cut.count(cut.safety, BeamStatus::none), 0U);
}

/// Firings with two returns, the first one (echo 0) from one cloud and the last from another.
Cloud dual_of(const Cloud& first, const Cloud& last) {
  Cloud dual = first;
  dual.columns.clear();
  dual.points_bytes.clear();
  const auto append = [&](const Cloud& from, std::size_t c, std::uint8_t echo) {
    CloudColumn column = from.columns[c];
    const std::size_t end = c + 1 < from.columns.size() ? from.columns[c + 1].first_point : from.size();
    const auto begin = from.points_bytes.begin() + static_cast<std::ptrdiff_t>(column.first_point * 22);
    const auto behind = from.points_bytes.begin() + static_cast<std::ptrdiff_t>(end * 22);
    column.first_point = static_cast<std::uint32_t>(dual.size());
    column.echo = echo;
    dual.columns.push_back(column);
    dual.points_bytes.insert(dual.points_bytes.end(), begin, behind);
  };
  for (std::size_t c = 0; c < first.columns.size(); ++c) append(first, c, 0), append(last, c, 1);
  return dual;
}

Cloud seen_alone(const sim::Object& object) {
  sim::Yard yard;
  yard.ground = false;
  yard.objects = {object};
  return seen(yard, lidar16());
}

TEST(Virtualizer, OfTwoReturnsTheLastIsTheSurface) {
  sim::Yard yard;
  yard.objects = {wall(15, -30, 15, 30)};
  // A fence at 8 m, whichever return comes first in the data.
  const Cloud far = seen(yard, lidar16());
  const Cloud near = seen_alone(wall(8, -30, 8, 30));
  for (const Cloud& dual : {dual_of(far, near), dual_of(near, far)}) {
    Cut cut;
    cut.make(dual, lidar16().pose);
    EXPECT_NEAR(cut.range(cut.strict, 0), 15, 0.01);
  }
}

TEST(Virtualizer, EarlierReturnsFromTheVehicleAreLeftOut) {
  sim::Yard yard;
  yard.objects = {wall(15, -30, 15, 30)};
  // A rail on the vehicle, through which the beams see.
  const Cloud dual = dual_of(seen_alone(wall(0.8, -0.5, 0.8, 0.5)), seen(yard, lidar16()));
  Cut cut;
  cut.settings.beams.early_returns = true;
  cut.frame = make_pose({0, 0, 1.9}, {0, 0, 0});
  cut.band = {-0.1, 0.1};
  cut.make(dual, lidar16().pose);
  EXPECT_NEAR(cut.range(cut.safety, 0), 0.8, 0.02);
  cut.footprint = Footprint({{-2, -1}, {1, -1}, {1, 1}, {-2, 1}});
  cut.make(dual, lidar16().pose);
  EXPECT_NEAR(cut.range(cut.safety, 0), 15, 0.02);
}

}  // namespace
}  // namespace lidard
