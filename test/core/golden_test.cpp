// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What merged and virtual scans, schedules and motion are made of the same random input stays as it is. That
// it is right, other tests say; these notice when it changes.
#include "test/support/golden.h"

#include <gtest/gtest.h>

#include <random>

#include "core/frames/cloud_layout.h"
#include "core/frames/ring_scan.h"
#include "core/motion/frame_motion.h"
#include "core/mounts/mount_check.h"
#include "core/virtual/virtualizer.h"
#include "test/support/merge_score.h"
#include "test/support/random_cloud.h"
#include "test/support/yard.h"

namespace lidard {
namespace {

using test::Sums;

std::vector<std::uint8_t> random_bytes(std::uint32_t seed, std::size_t count) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> bytes(count);
  for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

void add(Sums& sums, const MountCheck& mounts) {
  for (const MountDifference& pair : mounts.pairs()) {
    sums.add_exact("surfaces", static_cast<std::int64_t>(pair.surfaces));
    for (const double value : pair.sigma) sums.add("mounts", value);
    for (const double value : pair.correction) sums.add("correction", value);
    for (const bool is : pair.determined) sums.add_exact("determined", is ? 1 : 0);
    sums.add_exact("wrong", pair.is_wrong ? 1 : 0);
  }
}

void add(Sums& sums, const Visibility& visibility) {
  for (std::size_t beam = 0; beam < visibility.beams(); ++beam) {
    sums.add("covered", static_cast<double>(visibility.covered(beam)));
    sums.add_exact("state", static_cast<int>(visibility.state(beam)));
  }
}

void add(Sums& sums, const Merger& merger) {
  sums.add_exact("superseded", static_cast<std::int64_t>(merger.superseded()));
  sums.add_exact("out of order", static_cast<std::int64_t>(merger.out_of_order()));
  sums.add_exact("bad times", static_cast<std::int64_t>(merger.bad_times()));
  if (merger.visibility() != nullptr) add(sums, *merger.visibility());
}

constexpr const char* profiles[] = {"strict", "safety", "flatten"};

TEST(Golden, RandomCloudsAreCutAsBefore) {
  Sums sums;
  for (std::uint32_t seed = 200; seed < 220; ++seed) {
    const auto bytes = random_bytes(seed, 30000);
    sim::virtualize_bytes(bytes.data(), bytes.size(), [&](const VirtualScan& made, const Virtualizer& by) {
      sums.scan(made.profile == Profile::flatten  ? "flatten"
                : made.profile == Profile::strict ? "strict"
                                                  : "safety",
                *made.scan);
      sums.add_text("why", by.why_no_surfaces());
      sums.add_exact("own", static_cast<std::int64_t>(by.own_returns()));
    });
  }
  test::expect_golden("core_random_clouds.txt", sums.text());
}

/// Poses of 50 Hz of a vehicle that swings, with a gap after 1.5 s.
PoseTrack swinging(Stamp begin) {
  PoseTrack track;
  for (int i = 0; i < 150; ++i) {
    const double t = 0.02 * i;
    if (t > 1.5 && t < 1.85) continue;
    track.add(begin + span_from_seconds(t),
              make_pose({2 * t, 0.3 * std::sin(3 * t), 0.05 * t},
                        {0.02 * std::sin(5 * t), 0.03 * std::cos(4 * t), 0.4 * std::sin(2 * t)}));
  }
  return track;
}

/// Three scanners, one of them upside down and one tilted, on a vehicle that drives.
void add_driven_merge(const sim::MergeCase& set_up, const MergeSettings& settings, std::uint64_t seed,
                      Sums& sums) {
  const Stamp begin{1'700'000'000'000'000'000};
  const PoseTrack track = swinging(begin);
  sim::MergeScene scene = sim::make_scene(set_up, seed);
  const Pose mounts[] = {scene.scanners[0].pose(), scene.scanners[1].pose(),
                         make_pose({0.4, -0.2, 0.5}, {0.03, 0.06, 1.1})};
  scene.scanners.push_back(scene.scanners[0]);
  scene.scanners.back().yaw = 1.1;
  sim::Rng rng(seed);
  scene.scanners.back().measure(scene.world, rng, scene.scans.emplace_back());
  Merger merger(scene.grid, {-0.2, 1.1}, 3, settings);
  merger.set_footprint(scene.body);
  MountCheck mounting(3);
  PlanarScan out[3];
  Cloud cloud;
  for (int sweep = 0; sweep < 24; ++sweep) {
    const Stamp now = begin + std::chrono::milliseconds(60 * sweep);
    for (std::size_t s = 0; s < 3; ++s) {
      if ((sweep + static_cast<int>(s) * 3) % 11 == 0) continue;
      PlanarScan& scan = scene.scans[s];
      scan.stamp = now + std::chrono::milliseconds(static_cast<int>(s) * 7 - (sweep % 13 == 5 ? 200 : 0));
      scan.time_increment = 40e-6F;
      merger.add(s, scan, mounts[s]);
    }
    const MergeMoment moment{now + std::chrono::milliseconds(30), sweep % 9 == 4 ? nullptr : &track,
                             make_pose({0.1, 0, 0}, {0, 0, 0.05})};
    const std::vector<char> use = {1, sweep % 7 == 3 ? char(0) : char(1), 1};
    const MergeReport& report = merger.merge(
        moment, use, {{Profile::strict, &out[0]}, {Profile::safety, &out[1]}, {Profile::flatten, &out[2]}},
        &cloud);
    for (std::size_t i = 0; i < 3; ++i) sums.scan(profiles[i], out[i]);
    sums.cloud("cloud", cloud);
    for (const SourceUse one : report.sources) sums.add_exact("use", static_cast<int>(one));
    std::vector<const PlacedScan*> sweeps;
    std::vector<Eigen::Vector2d> places;
    for (std::size_t s = 0; s < 3; ++s) {
      sweeps.push_back(merger.sweep(s));
      places.push_back(merger.looks_from(s));
      if (sweeps.back() == nullptr) continue;
      sums.add_exact("own", static_cast<std::int64_t>(sweeps.back()->own_returns));
      sums.add_exact("through", static_cast<std::int64_t>(sweeps.back()->seen_through));
      sums.add_exact("doubtful", static_cast<std::int64_t>(sweeps.back()->mixed_pixels));
    }
    mounting.update(now, sweeps, places, sweep % 5 != 0);
    add(sums, mounting);
    add(sums, merger);
  }
}

TEST(Golden, ScannersThatDriveAreMergedAsBefore) {
  Sums sums;
  std::uint64_t seed = 10;
  for (const sim::MergeCase& set_up : sim::merge_cases()) {
    for (int variant = 0; variant < 4; ++variant) {
      MergeSettings settings;
      settings.visibility = true;
      settings.how.noise = settings.source.noise = 0.01;
      settings.how.free_required = variant == 2 ? 9 : 0;
      settings.source.echoes = variant == 1 ? EchoChoice::all : EchoChoice::last;
      settings.source.no_return_free_range = variant == 3 ? 12 : 40;
      add_driven_merge(set_up, settings, ++seed, sums);
    }
  }
  test::expect_golden("core_driven_merges.txt", sums.text());
}

/// A turning lidar over a yard, standing or driving, cut in all ways.
void add_cut_yard(const sim::YardScene& scene, int variant, Sums& sums) {
  VirtualSettings settings;
  settings.visibility = true;
  settings.how.noise = 0.02;
  settings.mode = variant % 2 == 0 ? CutMode::slice : CutMode::band;
  settings.ground.model = static_cast<GroundModel>(variant % 3);
  settings.ground.z = 0.02;
  settings.beams.no_return_free_range = variant % 4 == 3 ? 0 : 50;
  settings.beams.early_returns = variant % 2 == 1;
  Virtualizer virtualizer(scene.grid, {-0.1, 0.4}, 2, settings);
  virtualizer.set_footprint(Footprint({{-2, -1}, {1.5, -1}, {1.5, 1}, {-2, 1}}));
  const Pose mount = make_pose({0.1, 0.05, 2.0}, {0.02, -0.03, 0.4});
  const PoseTrack track = swinging(scene.cloud.stamp - std::chrono::milliseconds(500));
  CloudMotion motion;
  const bool moves = variant >= 3 && motion.find(scene.cloud, mount, track);
  sums.add_exact("moves", moves ? 1 : 0);
  virtualizer.set_cloud(scene.cloud, mount, moves ? &motion : nullptr);
  PlanarScan out[3];
  for (std::size_t frame = 0; frame < 2; ++frame) {
    const Pose at =
        frame == 0 ? scene.virtual_pose : make_pose({1.2, -0.4, 0.7}, {0.05 * variant, 0.04, -2.0});
    virtualizer.project(
        frame, at.inverse() * mount,
        {{Profile::strict, &out[0]}, {Profile::safety, &out[1]}, {Profile::flatten, &out[2]}});
    for (std::size_t i = 0; i < 3; ++i) sums.scan(profiles[i], out[i]);
    add(sums, virtualizer.visibility(frame));
    sums.add_exact("own", static_cast<std::int64_t>(virtualizer.own_returns()));
  }
}

TEST(Golden, YardsAreCutAsBefore) {
  Sums sums;
  for (const sim::YardCase& set_up : sim::yard_cases()) {
    const sim::YardScene scene = sim::make_yard_scene(set_up, 5);
    for (int variant = 0; variant < 6; ++variant) add_cut_yard(scene, variant, sums);
  }
  test::expect_golden("core_yards.txt", sums.text());
}

TEST(Golden, CloudsAreArrangedAndReducedToARingAsBefore) {
  Sums sums;
  for (const sim::YardCase& set_up : sim::yard_cases()) {
    sim::YardScene scene = sim::make_yard_scene(set_up, 6);
    for (std::size_t c = 3; c < scene.cloud.columns.size(); c += 50)
      scene.cloud.too_near.push_back({static_cast<std::uint32_t>(c), 2});
    for (int layout = 0; layout < 6; ++layout) {
      CloudArranger arranger({static_cast<CloudOrder>(layout % 3), static_cast<FrameStamp>(layout % 2)});
      const Cloud& arranged = arranger.arrange(scene.cloud);
      sums.cloud("arranged", arranged);
      sums.add_text("bytes", {reinterpret_cast<const char*>(arranged.points_bytes.data()),
                              arranged.points_bytes.size()});
    }
    for (const std::uint16_t ring : std::initializer_list<std::uint16_t>{0, 2, 7}) {
      RingScan converter({ring, 0.004, 0.9, 30});
      PlanarScan scan;
      for (int turn = 0; turn < 3; ++turn) {
        sums.add_exact("ring", converter.convert(scene.cloud, scan) ? 1 : 0);
        sums.scan("ring", scan);
        // A lidar that begins elsewhere, and a piece that is missing.
        for (CloudColumn& column : scene.cloud.columns) column.azimuth += 0.3F;
        if (turn == 1) scene.cloud.columns.resize(scene.cloud.columns.size() * 3 / 4);
      }
    }
  }
  test::expect_golden("core_layouts.txt", sums.text());
}

}  // namespace
}  // namespace lidard
