// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Random yards: which beams of a virtual scan are free follows from the columns on both sides of each place,
// beam by beam; nothing but the organised cloud is shared with what is compared.
// The environment variable LIDARD_RULE_SCENES sets the number of scenes; 3,000 are 100,000 beams.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>

#include "core/virtual/cut_evidence.h"
#include "test/core/virtual/cut_bench.h"

namespace lidard {
namespace {

constexpr double edge = 0.006;  // m; nearer to an edge than this, rounding may decide
constexpr double step = 0.01;   // m along a beam

/// What a column proves of the plane, m from the lidar: free from `from` to `to`. As far as `possible` a
/// thing that a lower ring meets may reach up to the plane or not.
struct Piece {
  double from, to, possible;
};
struct Column {
  double azimuth = 0;  // rad
  std::vector<Piece> pieces;

  bool surely(double d) const {
    return std::any_of(pieces.begin(), pieces.end(),
                       [d](const Piece& p) { return d > p.from + edge && d < p.to - edge; });
  }
  bool possibly(double d) const {
    return std::any_of(pieces.begin(), pieces.end(),
                       [d](const Piece& p) { return d > p.from - edge && d < p.possible + edge; });
  }
};

/// A lidar among boxes, and a plane beneath it or above it.
class ColumnScene {
 public:
  explicit ColumnScene(std::uint64_t seed)
      : rng_(seed), sign_(seed % 4 == 0 ? -1 : 1), above_(0.4 + 1.2 * rng_.uniform()) {
    sim::Yard yard;
    for (int i = 0; i < 12; ++i) {
      const double away = 3 + 14 * rng_.uniform(), towards = rng_.within(pi_d);
      const Eigen::Vector2d at(away * std::cos(towards), away * std::sin(towards));
      const double high = 0.3 + 2.5 * rng_.uniform(), wide = 0.1 + 2 * rng_.uniform();
      yard.objects.push_back(test::cut::box({at.x(), at.y(), high / 2}, {0.1 + rng_.uniform(), wide, high}));
    }
    sim::YardLidar lidar = test::cut::lidar16();
    lidar.noise = rng_.uniform() < 0.5 ? 0 : 0.01;
    cloud_ = sim::measure(yard, lidar, rng_);
    if (!grid_.organise(cloud_)) throw std::runtime_error(grid_.why_not());
    GroundSettings settings;
    settings.model = GroundModel::plane;
    find_ground(grid_, settings, lidar.pose, ground_);
    links_.set(grid_, 0.01);
    view_.set_cloud(grid_, ground_, links_, Eigen::Vector3f::UnitZ());
    const double away = 6 * rng_.uniform() + 2 * above_, towards = rng_.within(pi_d);
    origin_ = {away * std::cos(towards), away * std::sin(towards)};
    reach_ = 1 + 6 * rng_.uniform();
    for (std::size_t c = 0; c < grid_.columns(); ++c) columns_.push_back(prove(c));
    std::sort(columns_.begin(), columns_.end(),
              [](const Column& a, const Column& b) { return a.azimuth < b.azimuth; });
  }

  struct Count {
    std::size_t beams = 0, free = 0, taken = 0, different = 0;
  };
  void compare(std::uint64_t seed, Count& count) {
    VisibilitySettings how;
    how.free_required = reach_;
    const ScanGrid grid = test::cut::full_circle(720);
    Visibility visibility(grid, how, 1);
    view_.set_frame(make_pose({-origin_.x(), -origin_.y(), sign_ * above_}, {0, 0, 0}));
    view_.set_level(0);
    tops_.find(view_);
    visibility.begin();
    evidence_.find(view_, tops_, {0, 0}, 0, visibility);
    visibility.compute();
    for (std::size_t beam = seed % 20; beam < grid.beams; beam += 20) {
      ++count.beams;
      const auto [all, none] = walk(grid.angle(beam));
      const bool free = visibility.state(beam) == BeamState::free;
      count.free += all ? 1 : 0;
      count.taken += none ? 1 : 0;
      if (!(free && none) && !(!free && all)) continue;
      ++count.different;
      ADD_FAILURE() << "seed " << seed << ", beam " << beam << (free ? " is free, not" : " is not free, but")
                    << " by the rule; covered " << visibility.covered(beam) << " of " << reach_ << " m";
    }
  }

 private:
  /// Whether every place of the beam is surely free, and whether some place is surely not.
  std::pair<bool, bool> walk(double angle) const {
    bool all = true, none = false;
    for (double at = 0; at < reach_; at += step) {
      const Eigen::Vector2d p = origin_ + at * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      const double azimuth = std::atan2(p.y(), p.x()), d = p.norm();
      auto left = std::upper_bound(columns_.begin(), columns_.end(), azimuth,
                                   [](double a, const Column& column) { return a < column.azimuth; });
      const Column& right = left == columns_.begin() ? columns_.back() : *std::prev(left);
      if (left == columns_.end()) left = columns_.begin();
      all = all && left->surely(d) && right.surely(d);
      none = none || (!left->possibly(d) && !right.possibly(d));
    }
    return {all, none};
  }

  /// The ground does not end the view above it; what a beam meets otherwise may stand in the plane.
  Column prove(std::size_t c) const {
    constexpr double infinite = std::numeric_limits<double>::infinity();
    Column column;
    bool crosses_before = false, thing_before = false;
    double begin = 0, end_before = 0, at_before = 0;
    for (std::size_t k = 0; k < grid_.rings(); ++k) {
      const std::size_t i = grid_.index(c, sign_ > 0 ? k : grid_.rings() - 1 - k);
      const BeamEnd& e = grid_.ends[i];
      if (grid_.kind[i] == Beam::unknown) {
        crosses_before = false;
        continue;
      }
      column.azimuth = std::atan2(static_cast<double>(e.y), static_cast<double>(e.x));
      const double end = std::hypot(static_cast<double>(e.x), static_cast<double>(e.y));
      const double drop = -sign_ * static_cast<double>(e.z);  // towards the plane
      const bool crosses = drop > above_, hits = grid_.kind[i] == Beam::point;
      const double at = drop > 1e-9 ? end * above_ / drop : infinite;
      if (crosses && !crosses_before) begin = at;
      if (crosses_before) {
        const double seen_to = crosses ? at : end;
        const double sure = thing_before ? std::max(at_before, std::min(end_before, seen_to)) : seen_to;
        column.pieces.push_back({begin, sure, seen_to});
        // The piece goes on in one if nothing stands between.
        begin = crosses && !thing_before ? begin : at;
      }
      crosses_before = crosses;
      thing_before = hits && ground_.is_ground[i] != Ground::sure;
      end_before = end, at_before = at;
    }
    return column;
  }

  sim::Rng rng_;
  double sign_, above_, reach_ = 0;  // m
  Eigen::Vector2d origin_{0, 0};
  Cloud cloud_;
  RingGrid grid_{RingGridSettings{60, false}};
  Ground ground_;
  RingLinks links_;
  PlaneView view_;
  PlaneTops tops_;
  CutEvidence evidence_;
  std::vector<Column> columns_;
};

TEST(SlowColumns, DecideWhichBeamsOfAVirtualScanAreFree) {
  const char* const asked = std::getenv("LIDARD_RULE_SCENES");
  const std::uint64_t scenes = asked == nullptr ? 20 : std::strtoull(asked, nullptr, 10);
  ColumnScene::Count count;
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) ColumnScene(seed).compare(seed, count);
  if (asked != nullptr)
    std::cout << count.beams << " beams, " << count.free << " surely free, " << count.taken << " surely not, "
              << count.different << " different\n";
  EXPECT_EQ(count.different, 0U);
  EXPECT_GT(count.free + count.taken, count.beams / 2);
  EXPECT_GT(count.free, count.beams / 20);
}

}  // namespace
}  // namespace lidard
