// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// The merged cloud of two VLS-128 in dual return mode, on a vehicle that drives a curve: every beam with two
// returns, which is the most there can be (460 800 returns per turn and lidar). Counters: ms of the processor
// for taking the two clouds and for merging them, their share of a core at 10 turns/s, and the ms from the
// arrival of the last cloud to the finished bytes of the message.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/base/angle.h"
#include "core/merge/cloud_merger.h"
#include "test/bench/yardstick.h"

namespace lidard {
namespace {

constexpr std::size_t rings = 128, firings = 1800;
constexpr Span turn = std::chrono::milliseconds(100);

Cloud dual_cloud() {
  Cloud cloud;
  cloud.stamp = Stamp{1'700'000'000'000'000'000};
  cloud.rings = rings;
  cloud.points_bytes.resize(2 * firings * rings * sizeof(CloudPoint));
  std::uint32_t points = 0;
  for (std::size_t firing = 0; firing < firings; ++firing) {
    const double azimuth = two_pi * static_cast<double>(firing) / firings;
    const double after = seconds(turn) * static_cast<double>(firing) / firings;
    for (std::uint8_t echo = 0; echo < 2; ++echo) {
      cloud.columns.push_back(
          {points, 0, 0, echo, static_cast<float>(azimuth), cloud.stamp + span_from_seconds(after)});
      for (std::uint16_t ring = 0; ring < rings; ++ring) {
        const double range = 10 + 5 * std::sin(7 * azimuth) + echo;
        cloud.points()[points++] = {static_cast<float>(range * std::cos(azimuth)),
                                    static_cast<float>(-range * std::sin(azimuth)),
                                    static_cast<float>(0.02 * ring - 1),
                                    50,
                                    ring,
                                    static_cast<float>(after)};
      }
    }
  }
  cloud.end = cloud.columns.back().stamp;
  return cloud;
}

/// Poses every 20 ms on a circle, 5 m/s and 1 rad/s.
void drive_on(PoseTrack& track, Stamp begin, Stamp until) {
  while (track.empty() || track.newest() < until) {
    const Stamp next = track.empty() ? begin : track.newest() + std::chrono::milliseconds(20);
    const double yaw = std::fmod(1e-9 * static_cast<double>(next.ns % 1'000'000'000'000), two_pi);
    track.add(next, make_pose({5 * std::sin(yaw), 5 - 5 * std::cos(yaw), 0}, {0, 0, yaw}));
  }
}

void two_vls128(benchmark::State& state, bool organised, bool moving) {
  Cloud clouds[] = {dual_cloud(), dual_cloud()};
  const Pose mounts[] = {make_pose({0.5, 1, 2.8}, {0, 0.1, 0}), make_pose({-0.5, -1, 2.8}, {0, 0.1, 3})};
  CloudMerger merger(2, organised);
  PoseTrack track;
  MergedCloud messages[2];  // as many as are on their way
  const std::vector<char> both = {1, 1};
  std::vector<double> takes, merges, latencies;
  std::size_t number = 0;
  for (auto _ : state) {
    for (Cloud& cloud : clouds) {
      cloud.stamp = cloud.stamp + turn;
      cloud.end = cloud.end + turn;
      for (CloudColumn& column : cloud.columns) column.stamp = column.stamp + turn;
    }
    if (moving) drive_on(track, clouds[0].stamp - turn, clouds[0].end + std::chrono::milliseconds(20));
    const double begin = bench::cpu_seconds();
    merger.add(0, clouds[0], mounts[0]);
    const double last = bench::cpu_seconds();
    merger.add(1, clouds[1], mounts[1]);
    const double taken = bench::cpu_seconds();
    MergedCloud& merged = messages[number++ % 2];
    merger.merge({clouds[0].end, moving ? &track : nullptr}, both, merged);
    const double done = bench::cpu_seconds();
    benchmark::DoNotOptimize(merged.points_bytes.data());
    takes.push_back(taken - begin);
    merges.push_back(done - taken);
    latencies.push_back(done - last);
    state.SetIterationTime(done - begin);
  }
  state.counters["take_ms"] = 1000 * bench::median(takes);
  state.counters["merge_ms"] = 1000 * bench::median(merges);
  state.counters["latency_ms"] = 1000 * bench::median(latencies);
  state.counters["core_percent"] = 100 * (bench::median(takes) + bench::median(merges)) / seconds(turn);
}

BENCHMARK_CAPTURE(two_vls128, driving, false, true)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(two_vls128, standing, false, false)->UseManualTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(two_vls128, organised, true, true)->UseManualTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lidard

BENCHMARK_MAIN();
