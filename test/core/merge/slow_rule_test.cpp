// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Random scenes: what a merged scan says of each beam is what the rule of free space says, applied slowly.
// The environment variable LIDARD_RULE_SCENES sets the number of scenes of each set-up; 1,500 are 100,000
// beams.
#include "test/support/slow_rule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <vector>

#include "core/merge/merger.h"
#include "core/motion/pose_track.h"
#include "test/sim/world/circle.h"
#include "test/sim/world/units.h"

namespace lidard::sim {
namespace {

constexpr double instant = 1;  // s after t0
constexpr double reach = 12;   // m, of the output

struct Mount {
  double x, y, yaw_deg, field_deg, increment_deg;
};

struct RuleCase {
  const char* name;
  std::vector<Mount> scanners;
  double speed = 0, turn = 0;  ///< m/s and rad/s at most
  double drops = 0;            ///< share of the beams with a return nearer than anything
  double invalid = 0;          ///< share of the beams that the device does not vouch for
  bool mixed = false;          ///< beams touch two surfaces
  bool nonsense = false;       ///< ranges that no world has
};

const std::vector<RuleCase>& rule_cases() {
  static const std::vector<Mount> front = {{1, 0.5, 45, 270, 0.5}, {1, -0.5, -45, 270, 0.5}};
  static const std::vector<Mount> diagonal = {{1, 0.5, 45, 270, 0.25}, {-1, -0.5, -135, 270, 0.25}};
  static const std::vector<Mount> three = {
      {1.1, 0, 0, 190, 1}, {-0.3, 0.6, 120, 270, 1.0 / 3}, {-0.5, -0.7, -100, 240, 0.5}};
  static const std::vector<RuleCase> cases = {
      {"TwoInFront", front},
      {"TwoInFrontWithDrops", front, 0, 0, 0.02, 0.01, true},
      {"Diagonal", diagonal, 0, 0, 0, 0, true},
      {"ThreeOfDifferentIncrements", three, 0, 0, 0.005, 0.02, true},
      {"OneOfAFullCircle", {{0.2, 0.1, 30, 359.5, 0.5}}},
      {"OneOfALimitedField", {{0, 0, 0, 180, 1}}, 0, 0, 0.01, 0, true},
      {"TwoInFrontDriving", front, 5, 1.5},
      {"DiagonalDrivingWithDrops", diagonal, 5, 1.5, 0.01, 0.01, true},
      {"ThreeDriving", three, 3, 1.5, 0, 0, true},
      {"OneOfAFullCircleDriving", {{0.2, 0.1, 30, 359.5, 0.5}}, 5, 1.5, 0.005},
      {"Nonsense", {{0.3, 0, 0, 270, 0.5}, {-0.4, 0.2, 170, 200, 0.7}}, 0, 0, 0, 0.02, false, true},
      {"NonsenseDriving", {{0.3, 0, 0, 270, 0.5}, {-0.4, 0.2, 170, 200, 0.7}}, 5, 1.5, 0, 0.02, false, true}};
  return cases;
}

struct RuleCount {
  std::size_t beams = 0, judged = 0, free = 0, hits = 0, different = 0, falsely_free = 0;
};

/// A scene of a set-up, and what a merge and the rule make of it.
class RuleScene {
 public:
  RuleScene(const RuleCase& set_up, std::uint64_t seed) : set_up_(set_up), seed_(seed), rng_(seed) {
    grid_ = test::full_circle(rng_.uniform() < 0.5 ? 720 : 1440, reach);
    settings_.points = false;
    settings_.visibility = true;
    settings_.how.noise = settings_.source.noise = 0.01;
    settings_.source.veil_filter = rng_.uniform() < 0.8;
    build_world();
    speed_ = set_up.speed * rng_.within(1);
    turn_ = set_up.turn * rng_.within(1);
    sweep_s_ = 0.025 + 0.075 * rng_.uniform();
    output_ = make_pose({rng_.within(1.5), rng_.within(1.5), 0}, {0, 0, rng_.within(pi_d)});
    if (rng_.uniform() < 0.3) output_ = Pose::Identity();
  }

  void compare(RuleCount& count) {
    Merger merger(grid_, {}, set_up_.scanners.size(), settings_);
    const Footprint outline =
        rng_.uniform() < 0.7 ? Footprint({{-1, -0.5}, {1, -0.5}, {1, 0.5}, {-1, 0.5}}).transformed(output_)
                             : Footprint();
    merger.set_footprint(outline);
    MergeMoment moment;
    moment.at = t0 + span_from_seconds(instant);
    moment.output_from_base = output_;
    PoseTrack track;
    for (int i = 0; i <= 102; ++i) track.add(t0 + span_from_seconds(0.01 * i), to_pose(place(0.01 * i)));
    if (set_up_.speed > 0) moment.track = &track;
    std::vector<BeamRays> rays(set_up_.scanners.size());
    std::optional<Stamp> oldest;
    std::optional<Pose> former;
    for (std::size_t s = 0; s < rays.size(); ++s) {
      const PlanarScan scan = measure(s);
      ASSERT_EQ(violation(scan), nullptr);
      ASSERT_TRUE(merger.add(s, scan, pose_of(s)));
      rays[s].build(scan, pose_of(s), outline, {});
      SweepMotion motion;
      motion.follow(moment, times_of(scan));
      if (motion.stands() || (oldest && *oldest < scan.stamp)) continue;
      oldest = scan.stamp;
      former = motion.begin().inverse();
    }
    PlanarScan strict;
    merger.merge(moment, std::vector<char>(rays.size(), 1), {{Profile::strict, &strict}}, nullptr);
    SlowRule rule(grid_, settings_.how, rule_settings(), outline, former);
    for (std::size_t s = 0; s < rays.size(); ++s) rule.add(*merger.sweep(s), rays[s]);
    const std::vector<Claim> claims = claims_of_scan(strict);
    for (std::size_t beam = seed_ % stride; beam < claims.size(); beam += stride)
      judge(beam, claims[beam], rule.answer(beam), count);
  }

 private:
  static constexpr std::size_t stride = 16;

  static SlowRuleSettings rule_settings() {
    SlowRuleSettings settings;
    if (const char* edge = std::getenv("LIDARD_RULE_EDGE")) settings.edge = std::strtod(edge, nullptr);
    return settings;
  }

  void build_world() {
    if (rng_.uniform() < 0.4)
      world_.add_box({0, 0}, {7 + 8 * rng_.uniform(), 4 + 6 * rng_.uniform()}, rng_.within(1));
    for (int i = 0; i < 14; ++i) {
      const double away = 1.8 + 9 * rng_.uniform(), towards = rng_.within(pi_d);
      const double half = std::min(0.03 + 0.5 * rng_.uniform(), (away - 1.5) / 2);
      world_.add_box({away * std::cos(towards), away * std::sin(towards)},
                     {half, 0.02 + half * rng_.uniform()}, rng_.within(pi_d));
    }
  }

  Pose2 place(double after) const {
    const double t = after - instant;
    return {speed_ * t, 0.1 * speed_ * t, turn_ * t};
  }
  FlatScanner scanner(std::size_t s) const {
    const Mount& mount = set_up_.scanners[s];
    FlatScanner scanner;
    scanner.at = {mount.x, mount.y};
    scanner.yaw = mount.yaw_deg * degree;
    scanner.field = mount.field_deg * degree;
    scanner.increment = mount.increment_deg * degree;
    scanner.range_max = 20;
    scanner.noise = 0.01;
    scanner.spot = set_up_.mixed ? 0.1 * degree : 0;
    return scanner;
  }
  Pose pose_of(std::size_t s) const { return output_ * scanner(s).pose(); }

  PlanarScan measure(std::size_t s) {
    const FlatScanner by = scanner(s);
    const double between = sweep_s_ / (by.field / by.increment),
                 begin = instant - sweep_s_ - 0.03 * rng_.uniform();
    PlanarScan scan;
    by.measure(
        world_, [&](std::size_t beam) { return place(begin + static_cast<double>(beam) * between); }, rng_,
        scan);
    double range = 5;
    for (std::size_t i = 0; i < scan.beams; ++i) {
      if (set_up_.nonsense) {
        if (rng_.uniform() < 0.1) range = 0.3 + 14 * rng_.uniform();
        range = std::max(0.2, range + rng_.within(0.02));
        if (range < 13)
          scan.set_hit(i, static_cast<float>(range));
        else
          scan.set_without_hit(i, BeamStatus::none);
      }
      const double until = scan.statuses[i] == BeamStatus::hit ? static_cast<double>(scan.ranges[i]) : 6;
      if (rng_.uniform() < set_up_.drops)
        scan.set_hit(i, static_cast<float>(0.2 + (std::min(until, 6.0) - 0.2) * rng_.uniform()));
      if (rng_.uniform() < set_up_.invalid) scan.set_without_hit(i, BeamStatus::invalid);
    }
    scan.stamp = t0 + span_from_seconds(begin);
    scan.time_increment = static_cast<float>(between);
    return scan;
  }

  void judge(std::size_t beam, const Claim& claim, const SlowAnswer& answer, RuleCount& count) const {
    ++count.beams;
    if (!answer.sure) return;
    ++count.judged;
    count.free += answer.claim.kind == Claim::free ? 1 : 0;
    count.hits += answer.claim.kind == Claim::hit ? 1 : 0;
    const bool same = claim.kind == answer.claim.kind;
    if (same && (claim.kind != Claim::hit || std::fabs(claim.range - answer.claim.range) <= answer.slack))
      return;
    ++count.different;
    count.falsely_free += claim.kind == Claim::free ? 1 : 0;
    if (count.different > 20) return;
    static const char* const kinds[] = {"nothing", "free", "hit"};
    ADD_FAILURE() << set_up_.name << ", seed " << seed_ << ", beam " << beam << " of " << grid_.beams << ": "
                  << kinds[claim.kind] << " at " << claim.range << " m, by the rule "
                  << kinds[answer.claim.kind] << " at " << answer.claim.range << " m, walked to "
                  << answer.walked_to << " m";
  }

  const RuleCase& set_up_;
  std::uint64_t seed_;
  Rng rng_;
  ScanGrid grid_;
  MergeSettings settings_;
  FlatWorld world_;
  double speed_ = 0, turn_ = 0, sweep_s_ = 0;
  Pose output_ = Pose::Identity();
};

class SlowRuleScenes : public ::testing::TestWithParam<std::size_t> {};

TEST_P(SlowRuleScenes, SayOfEachBeamWhatTheRuleSays) {
  const RuleCase& set_up = rule_cases()[GetParam()];
  const char* const asked = std::getenv("LIDARD_RULE_SCENES");
  const std::uint64_t scenes = asked == nullptr ? 3 : std::strtoull(asked, nullptr, 10);
  RuleCount count;
  for (std::uint64_t seed = 1; seed <= scenes; ++seed) RuleScene(set_up, seed).compare(count);
  if (asked != nullptr) {
    std::cout << set_up.name << ": " << count.beams << " beams, " << count.judged << " judged, " << count.free
              << " free, " << count.hits << " hits, " << count.different << " different, "
              << count.falsely_free << " falsely free\n";
  }
  EXPECT_EQ(count.different, 0U) << "of " << count.judged;
  EXPECT_GT(count.judged * 10, count.beams * 7);
  EXPECT_GT(count.free, 0U);
  EXPECT_GT(count.hits, count.beams / 20);
}

INSTANTIATE_TEST_SUITE_P(SetUps, SlowRuleScenes, ::testing::Range<std::size_t>(0, rule_cases().size()),
                         [](const auto& each) { return rule_cases()[each.param].name; });

}  // namespace
}  // namespace lidard::sim
