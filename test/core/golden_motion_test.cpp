// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What schedules, motion, clocks and revolutions are made of the same random input stays as it is.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/device_clock.h"
#include "core/frames/revolution.h"
#include "core/merge/scheduler.h"
#include "core/motion/frame_motion.h"
#include "core/motion/pose_track.h"
#include "test/sim/world/rng.h"
#include "test/support/golden.h"

namespace lidard {
namespace {

using test::Sums;

/// Sources of 10, 15 and 40 Hz that are late, fall silent, stamp oddly and come back.
void add_schedule(const ScheduleSettings& settings, std::uint64_t seed, Sums& sums) {
  Scheduler scheduler(3, settings);
  sim::Rng rng(seed);
  Stamp now{1'700'000'000'000'000'000};
  Stamp due[3] = {now, now, now};
  const int period_ms[3] = {100, 66, 25};
  for (int step = 0; step < 3000; ++step) {
    now = now + std::chrono::microseconds(1000 + static_cast<std::int64_t>(rng.bits() % 9000));
    if (step == 1500) now = now - std::chrono::seconds(7);
    if (step == 2200) scheduler.reset();
    for (std::size_t s = 0; s < 3; ++s) {
      if (due[s] - now > std::chrono::seconds(1)) due[s] = now;
      if (now < due[s]) continue;
      const bool silent = (step / 300 + static_cast<int>(s)) % 4 == 0;
      due[s] = due[s] + std::chrono::milliseconds(period_ms[s] * (rng.uniform() < 0.05 ? 3 : 1));
      if (silent) continue;
      const Stamp end = now - std::chrono::milliseconds(static_cast<int>(rng.uniform() * 12));
      scheduler.delivered(s, end, s == 1 ? 0.066 : 0, now);
    }
    for (std::size_t s = 0; s < 3; ++s) {
      sums.add_exact("state", static_cast<int>(scheduler.state(s, now)));
      sums.add("period", 1000 * scheduler.period(s));
    }
    const auto event = scheduler.next_event();
    sums.add_exact("event", event ? (*event - now).count() : -1);
    sums.add_exact("deadline", scheduler.deadline().count());
    const bool is_due = scheduler.is_due(now);
    sums.add_exact("due", is_due ? 1 : 0);
    for (const char use : scheduler.usable(now)) sums.add_exact("use", use);
    if (is_due) scheduler.done(now);
  }
  sums.add_exact("missed", static_cast<std::int64_t>(scheduler.deadlines_missed()));
  sums.add_exact("restarts", static_cast<std::int64_t>(scheduler.restarts()));
}

TEST(Golden, OutputsAreScheduledAsBefore) {
  Sums sums;
  std::uint64_t seed = 1;
  for (const Policy policy : {Policy::complete, Policy::rate, Policy::trigger}) {
    for (int variant = 0; variant < 4; ++variant) {
      ScheduleSettings settings;
      settings.policy = policy;
      settings.rate = 12;
      settings.trigger = static_cast<std::size_t>(variant % 3);
      if (variant == 1) settings.deadline = std::chrono::milliseconds(15);
      if (variant == 2) settings.lost_after = std::chrono::milliseconds(120);
      add_schedule(settings, ++seed, sums);
    }
  }
  test::expect_golden("core_schedules.txt", sums.text());
}

void add(Sums& sums, const std::string& name, const Pose& pose) {
  for (const double value : pose.matrix().reshaped()) sums.add(name, 100 * value);
}

TEST(Golden, MotionIsFoundAsBefore) {
  Sums sums;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    sim::Rng rng(seed);
    PoseTrackSettings settings;
    settings.knots = seed % 3 == 0 ? 40 : 1024;
    PoseTrack track(settings), reckoned(settings);
    DeadReckoning reckoning;
    Stamp now{1'700'000'000'000'000'000};
    for (int i = 0; i < 400; ++i) {
      now = now + std::chrono::microseconds(static_cast<std::int64_t>(rng.uniform() * 40000));
      if (rng.uniform() < 0.03) now = now - std::chrono::milliseconds(rng.uniform() < 0.2 ? 1500 : 30);
      if (rng.uniform() < 0.03) now = now + std::chrono::milliseconds(rng.uniform() < 0.2 ? 1200 : 270);
      const double t = 0.02 * i;
      Pose pose = make_pose({t, std::sin(t), 0.1 * t}, {0.1 * std::sin(t), 0.1 * std::cos(2 * t), 0.7 * t});
      if (rng.uniform() < 0.01) pose.matrix()(0, 1) = 3;
      if (rng.uniform() < 0.01) pose.matrix()(0, 3) = std::nan("");
      sums.add_exact("taken", track.add(now, pose) ? 1 : 0);
      reckoning.speed(rng.uniform() < 0.02 ? std::nan("") : 1 + std::sin(t));
      reckoning.turn(now, {0.1 * std::cos(t), 0.05, rng.uniform() < 0.02 ? INFINITY : std::sin(t)}, reckoned);
      for (int probe = 0; probe < 6; ++probe) {
        const Stamp at = now + span_from_seconds(0.4 * rng.uniform() - 0.3);
        Pose found = Pose::Identity();
        sums.add_exact("origin", static_cast<int>(track.at(at, found)));
        add(sums, "pose", found);
        sums.add_exact("reckoned origin", static_cast<int>(reckoned.at(at, found)));
        add(sums, "reckoned", found);
        const Stamp end = at + span_from_seconds(0.1 * rng.uniform());
        sums.add_exact("covers", track.covers(at, end) ? 1 : 0);
        Cloud cloud;
        cloud.stamp = at, cloud.end = end;
        for (int c = 0; c < 5; ++c)
          cloud.columns.push_back({0, 0, 0, 0, 0, at + std::chrono::milliseconds(9 * c)});
        CloudMotion motion;
        const bool moves = motion.find(cloud, make_pose({1, 0, 2}, {0, 0.1, 0.3}), track);
        sums.add_exact("moves", moves ? 1 : 0);
        if (!moves) continue;
        sums.add_exact("instant", motion.instant().ns);
        for (const double after : {-0.01, 0.0, 0.013, 0.05, 0.2}) add(sums, "cloud", motion.at(after));
        for (const Pose& column : motion.columns()) add(sums, "column", column);
      }
    }
    for (const PoseTrack* one : {&track, &reckoned}) {
      sums.add_exact("out of order", static_cast<std::int64_t>(one->out_of_order()));
      sums.add_exact("restarts", static_cast<std::int64_t>(one->restarts()));
      sums.add_exact("not rigid", static_cast<std::int64_t>(one->not_rigid()));
      sums.add_exact("size", static_cast<std::int64_t>(one->size()));
      sums.add_exact("oldest", one->oldest().ns);
    }
    sums.add_exact("refused", static_cast<std::int64_t>(reckoning.refused()));
  }
  test::expect_golden("core_motion.txt", sums.text());
}

TEST(Golden, ClocksAndRevolutionsAreFollowedAsBefore) {
  Sums sums;
  for (std::uint64_t seed = 1; seed <= 16; ++seed) {
    sim::Rng rng(seed);
    DeviceClock clock(seed % 2 == 0 ? ClockMode::smooth : ClockMode::arrival);
    RevolutionCutter cutter(40.0 * static_cast<double>(seed));
    Span device = std::chrono::seconds(5);
    Span shift{0};
    double azimuth = 350, speed_deg = 3.6;
    for (int i = 0; i < 6000; ++i) {
      device += std::chrono::microseconds(1000 + static_cast<std::int64_t>(rng.bits() % 7));
      if (rng.uniform() < 0.002) device += span_from_seconds(rng.uniform() * 0.3);
      if (rng.uniform() < 0.0005) device -= std::chrono::seconds(2);
      if (rng.uniform() < 0.0005) shift += span_from_seconds(4 * rng.uniform() - 2);
      if (rng.uniform() < 0.003) shift += span_from_seconds(0.12 * rng.uniform() - 0.06);
      const double late = rng.uniform() < 0.01 ? 0.03 : 0.0004 * rng.uniform();
      const Span drifting = span_from_seconds(seconds(device) * 60e-6);
      const Stamp arrival =
          Stamp{1'700'000'000'000'000'000} + device + drifting + shift + span_from_seconds(late);
      clock.observe(device, arrival);
      sums.add_exact("host", clock.to_host(device + std::chrono::microseconds(300)).ns);
      sums.add("drift", clock.drift_ppm());
      if (rng.uniform() < 0.001) azimuth += 120;
      if (rng.uniform() < 0.003) azimuth += 360 - 0.1;
      if (rng.uniform() < 0.0008) speed_deg = 1 + 6 * rng.uniform();
      if (i % 1700 == 1600) speed_deg = 0;
      azimuth = std::fmod(azimuth + speed_deg, 360);
      sums.add_exact("turn", static_cast<int>(cutter.next(azimuth, device)));
      sums.add_exact("period", cutter.period().count());
      if (i == 4000) cutter.reset();
    }
    sums.add_exact("steps", static_cast<std::int64_t>(clock.steps()));
  }
  test::expect_golden("core_clocks.txt", sums.text());
}

}  // namespace
}  // namespace lidard
