// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "test/support/random_merge.h"

#include <cmath>
#include <cstdlib>

#include "core/merge/merger.h"
#include "core/mounts/mount_check.h"
#include "test/sim/world/units.h"
#include "test/support/random_bytes.h"

namespace lidard::sim {
namespace {

MergeSettings read_merge_settings(Bytes& in) {
  MergeSettings settings;
  settings.points = settings.visibility = true;
  settings.how.noise = settings.source.noise = in.between(0, 0.1);
  if (in.chance(40)) settings.how.free_required = in.between(0, 100);
  settings.source.echoes = static_cast<EchoChoice>(in.below(4));
  settings.source.veil_filter = in.chance(200);
  if (in.chance(40)) settings.source.angle_max = in.between(-4, 4);
  if (in.chance(40)) settings.source.no_return_free_range = in.between(0, 10);
  return settings;
}

/// A sweep of anything: runs of surfaces, single returns, values from the edge of what is possible.
void read_scan(Bytes& in, PlanarScan& scan) {
  const std::size_t beams = in.chance(10) ? 1 + in.below(3) : 1 + in.below(700);
  scan.reset(beams, in.chance(40) ? 1 + in.below(3) : 1, in.chance(128));
  const double increment = in.between(1e-4, 2 * pi_d) / static_cast<double>(beams);
  scan.set_angles(static_cast<float>(in.between(-4, 4)),
                  static_cast<float>(in.chance(60) ? -increment : increment));
  scan.range_min = static_cast<float>(in.between(0, 0.3));
  scan.range_max = static_cast<float>(in.between(0.5, in.chance(20) ? 1e6 : 60));
  scan.time_increment = in.chance(10) ? in.any_float() : static_cast<float>(in.between(0, 1e-4));
  double range = in.between(0, 20);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const std::uint8_t what = in.byte();
    if (what < 20) range = in.between(0, 40);
    range += (static_cast<double>(what) - 128) * 1e-4;
    const float r = what == 21 ? scan.range_min : what == 22 ? scan.range_max : static_cast<float>(range);
    if (what < 230 && r >= scan.range_min && r <= scan.range_max)
      scan.set_hit(i, r);
    else
      scan.set_without_hit(i, what % 3 == 0   ? BeamStatus::none
                              : what % 3 == 1 ? BeamStatus::near
                                              : BeamStatus::invalid);
    if (!scan.intensities.empty())
      scan.intensities[i] = what == 23 ? in.any_float() : static_cast<float>(what);
  }
}

}  // namespace

std::size_t merge_bytes(const std::uint8_t* data, std::size_t size,
                        const std::function<void(const RandomMerge&)>& look) {
  Bytes in(data, size);
  const ScanGrid grid = read_grid(in);
  const std::size_t sources = 1 + in.below(3);
  const HeightBand band = read_band(in);
  Merger merger(grid, band, sources, read_merge_settings(in));
  if (in.chance(128)) merger.set_footprint(read_footprint(in));
  std::vector<Pose> poses;
  for (std::size_t s = 0; s < sources; ++s) poses.push_back(read_pose(in));
  PlanarScan scan;
  PlanarScan out[3];
  MountCheck mounts(sources);
  std::vector<const PlacedScan*> sweeps(sources, nullptr);
  std::vector<Eigen::Vector2d> places(sources, Eigen::Vector2d::Zero());
  Cloud cloud;
  Stamp now{1'000'000'000'000};
  std::size_t outputs = 0;
  PoseTrack track;
  std::vector<char> use(sources, 1);
  while (!in.empty()) {
    const std::size_t source = in.below(sources);
    if (in.chance(10)) poses[source] = read_pose(in);
    if (in.chance(5)) merger.set_footprint(read_footprint(in));
    read_scan(in, scan);
    now = now +
          std::chrono::microseconds(static_cast<std::int64_t>(in.below(65536)) * (in.chance(20) ? -40 : 1));
    scan.stamp = now;
    if (violation(scan) != nullptr) continue;
    if (in.chance(128)) track.add(now, read_pose(in));
    if (!merger.add(source, scan, poses[source])) continue;
    use[in.below(sources)] = in.chance(240) ? 1 : 0;
    const MergeMoment moment{now + std::chrono::milliseconds(in.below(80)), in.chance(128) ? &track : nullptr,
                             poses[0]};
    const MergeReport& report = merger.merge(
        moment, use, {{Profile::strict, &out[0]}, {Profile::safety, &out[1]}, {Profile::flatten, &out[2]}},
        &cloud);
    for (const PlanarScan& merged : out) check(merged, grid);
    for (std::size_t s = 0; s < sources; ++s) {
      sweeps[s] = merger.sweep(s);
      places[s] = merger.looks_from(s);
    }
    mounts.update(now, sweeps, places, true);
    for (const MountDifference& pair : mounts.pairs()) {
      if (!pair.correction.allFinite() || !pair.sigma.allFinite()) std::abort();
    }
    if (look) look({out, cloud, merger, report, mounts});
    ++outputs;
  }
  return outputs;
}

}  // namespace lidard::sim
