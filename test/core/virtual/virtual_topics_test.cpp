// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Clouds of other drivers' topics, in whatever order and with or without rings, against the same cloud as our
// drivers make it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "test/core/virtual/cut_bench.h"
#include "test/support/yard.h"

namespace lidard {
namespace {

using namespace test::cut;

/// How a topic has the points of a revolution.
struct Order {
  const char* name;
  void (*arrange)(Cloud& cloud);
  double loss;  // percent of right beams that this costs, at most
};

void by_firing(Cloud& /*cloud*/) {}

/// Rows of an organised message.
void by_ring(Cloud& cloud) {
  std::stable_sort(cloud.points(), cloud.points() + cloud.size(),
                   [](const CloudPoint& a, const CloudPoint& b) { return a.ring < b.ring; });
}

/// Highest ring first, as drivers have it that count rings from above.
void by_ring_from_above(Cloud& cloud) {
  for (std::size_t i = 0; i < cloud.size(); ++i)
    cloud.points()[i].ring = static_cast<std::uint16_t>(cloud.rings - 1 - cloud.points()[i].ring);
  by_ring(cloud);
}

/// In bins of azimuth, counter-clockwise from behind.
void by_azimuth(Cloud& cloud) {
  std::stable_sort(
      cloud.points(), cloud.points() + cloud.size(),
      [](const CloudPoint& a, const CloudPoint& b) { return std::atan2(a.y, a.x) < std::atan2(b.y, b.x); });
}

void shuffled(Cloud& cloud) {
  sim::Rng rng(11);
  for (std::size_t i = cloud.size() - 1; i > 0; --i)
    std::swap(cloud.points()[i],
              cloud.points()[static_cast<std::size_t>(rng.uniform() * static_cast<double>(i + 1))]);
}

void by_ring_without_rings(Cloud& cloud) {
  by_ring(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.points()[i].ring = 0;
  cloud.rings = 1;
}

void by_firing_without_rings(Cloud& cloud) {
  for (std::size_t i = 0; i < cloud.size(); ++i) cloud.points()[i].ring = 0;
  cloud.rings = 1;
}

/// Coordinates in whole millimetres.
void rounded(Cloud& cloud) {
  by_ring(cloud);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    CloudPoint& p = cloud.points()[i];
    p.x = std::round(p.x * 1000) / 1000, p.y = std::round(p.y * 1000) / 1000,
    p.z = std::round(p.z * 1000) / 1000;
  }
}

class VirtualTopics : public ::testing::TestWithParam<Order> {};

TEST_P(VirtualTopics, ShowAYardNearlyAsWellAsCloudsWhoseColumnsAreKnown) {
  for (const std::size_t which : {0U, 3U}) {
    sim::YardScore known, topic;
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      sim::YardScene scene = sim::make_yard_scene(sim::yard_cases()[which], seed);
      known.add(sim::judge_yard(scene, sim::cut_claims(scene, Profile::safety)));
      scene.cloud.columns.clear();
      GetParam().arrange(scene.cloud);
      topic.add(sim::judge_yard(scene, sim::cut_claims(scene, Profile::safety)));
    }
    const std::string figures = "right " + std::to_string(topic.share(topic.right)) + " %, known columns " +
                                std::to_string(known.share(known.right)) + " %, phantom " +
                                std::to_string(topic.share(topic.phantom)) + " %";
    RecordProperty("yard_" + std::to_string(which), figures);
    SCOPED_TRACE(figures);
    EXPECT_GE(topic.share(topic.right), known.share(known.right) - GetParam().loss);
    EXPECT_LE(topic.share(topic.phantom), known.share(known.phantom) + 0.8);
    EXPECT_EQ(topic.free, 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(Orders, VirtualTopics,
                         ::testing::Values(Order{"firing", by_firing, 1}, Order{"ring", by_ring, 1},
                                           Order{"ring_from_above", by_ring_from_above, 1},
                                           Order{"azimuth", by_azimuth, 1}, Order{"shuffled", shuffled, 1},
                                           Order{"ring_without_rings", by_ring_without_rings, 1},
                                           Order{"firing_without_rings", by_firing_without_rings, 1},
                                           Order{"rounded", rounded, 1}),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace lidard
