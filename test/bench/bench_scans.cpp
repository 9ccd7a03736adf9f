// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// What one core has to do per scan: merging two safety scanners, and looking at a VLP-16's revolution from
// two virtual scanners. (Decoding their telegrams: bench_decode.)
#include <cmath>

#include "core/merge/merger.h"
#include "core/virtual/virtualizer.h"
#include "drivers/model.h"
#include "drivers/registry/registry.h"
#include "test/bench/yardstick.h"
#include "test/sim/servers/velodyne_stream.h"
#include "test/sim/world/units.h"

namespace lidard {
namespace {

ScanGrid full_circle() {
  ScanGridSpec spec;
  spec.beams = 1440;
  spec.range_max = 50;
  return make_grid(spec).value();
}

/// 270 deg of a room whose walls are 3 to 9 m away; every tenth beam meets nothing.
PlanarScan room_scan() {
  PlanarScan scan;
  scan.reset(1081, 1, true);
  scan.set_angles(static_cast<float>(-0.75 * pi_d), static_cast<float>(1.5 * pi_d / 1080));
  scan.range_max = 60;
  scan.scan_time = 0.04F;
  for (std::size_t i = 0; i < scan.beams; ++i) {
    scan.intensities[i] = static_cast<float>(i % 256);
    if (i % 10 == 9) {
      scan.set_without_hit(i, BeamStatus::none);
    } else {
      scan.set_hit(i, 6 + 3 * std::sin(0.02F * static_cast<float>(i)));
    }
  }
  return scan;
}

void merge(benchmark::State& state) {
  Merger merger(full_circle(), {}, 2);
  const Pose left = make_pose({1.2, 0.6, 0.2}, {0, 0, pi_d / 4});
  const Pose right = make_pose({-1.2, -0.6, 0.2}, {0, 0, -0.75 * pi_d});
  PlanarScan scan = room_scan();
  PlanarScan merged;
  const std::vector<MergedScan> outputs = {{Profile::flatten, &merged}};
  const std::vector<char> both = {1, 1};
  std::size_t beams = 0;
  for (auto _ : state) {
    scan.stamp = scan.stamp + std::chrono::milliseconds(40);
    merger.add(0, scan, left);
    merger.add(1, scan, right);
    merger.merge({scan.stamp}, both, outputs, nullptr);
    beams += 2 * scan.beams;
    benchmark::DoNotOptimize(merged.ranges.data());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(beams));
}

/// Keeps a whole revolution.
class LastCloud final : public FrameReceiver {
 public:
  void scan(PlanarScan& /*scan*/) override {}
  void cloud(Cloud& cloud) override {
    if (cloud.complete) last = cloud;
  }
  Cloud last;
};

void virtualize(benchmark::State& state) {
  DriverConfig config;
  config.model = find_model("velodyne_vlp16");
  const auto driver = config.model->make(config);
  LastCloud output;
  const Endpoint sensor{IpAddress::v4(192, 168, 1, 201), 2368};
  for (const auto& packet : sim::simulate_velodyne({}))
    driver->receive({packet.view(), packet.arrival, sensor, {{}, packet.port}}, output);
  Virtualizer virtualizer(full_circle(), {-0.2, 0.2});
  const Pose from_cloud = make_pose({-1.5, 0, 0.8}, {0, 0, 0});
  PlanarScan scan;
  std::size_t points = 0;
  for (auto _ : state) {
    virtualizer.set_cloud(output.last, Pose::Identity());
    virtualizer.project(0, from_cloud, {{Profile::flatten, &scan}});
    points += output.last.size();
    benchmark::DoNotOptimize(scan.ranges.data());
  }
  if (points == 0) state.SkipWithError("no whole revolution");
  state.SetItemsProcessed(static_cast<std::int64_t>(points));
}

BENCHMARK(merge)->Name("merge/two_of_1081_to_1440")->Unit(benchmark::kMicrosecond);
BENCHMARK(virtualize)->Name("virtualize/vlp16_revolution")->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace lidard

BENCHMARK_MAIN();
