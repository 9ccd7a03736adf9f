// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// Virtual scans of one revolution of 16 rings: ours in profile strict, and the chain of conversions of
// ira_laser_tools rebuilt from the libraries it uses, in one program.
#include <benchmark/benchmark.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/common/io.h>
#include <pcl/common/transforms.h>
#include <pcl/conversions.h>
#include <pcl/point_types.h>

#include <cmath>
#include <variant>

#include "core/virtual/virtualizer.h"
#include "test/support/yard.h"

namespace lidard {
namespace {

/// A yard with walls so high that each of the 28800 beams comes back.
sim::YardScene walled_yard() {
  sim::YardScene scene = sim::make_yard_scene(sim::yard_cases()[0], 1);
  for (sim::Object& object : scene.yard.objects) {
    if (auto* wall = std::get_if<sim::Wall>(&object.shape)) wall->z_max = 20;
  }
  sim::Rng rng(1);
  scene.cloud = sim::measure(scene.yard, scene.lidar, rng);
  return scene;
}

const sim::YardScene& scene() {
  static const sim::YardScene made = walled_yard();
  return made;
}

Pose frame_pose(std::size_t frame) {
  const double height = 0.5 + 0.3 * static_cast<double>(frame);
  return make_pose({1.5, 0, height}, {0, 0, 0}).inverse() * scene().lidar.pose;
}

void ours(benchmark::State& state, Profile profile, CutMode mode) {
  const auto frames = static_cast<std::size_t>(state.range(0));
  VirtualSettings settings;
  settings.visibility = profile != Profile::flatten;
  settings.mode = mode;
  settings.ground.model = GroundModel::plane;
  settings.beams.no_return_free_range = 100;
  const HeightBand band = mode == CutMode::band ? HeightBand{-0.2, 1.0} : HeightBand{-0.1, 0.1};
  Virtualizer virtualizer(scene().grid, band, frames, settings);
  PlanarScan scan;
  const std::vector<VirtualScan> outputs = {{profile, &scan}};
  const auto once = [&] {
    virtualizer.set_cloud(scene().cloud, scene().lidar.pose);
    for (std::size_t f = 0; f < frames; ++f) virtualizer.project(f, frame_pose(f), outputs);
  };
  once();
  for (auto _ : state) once();
  benchmark::DoNotOptimize(scan.ranges.data());
  state.counters["returns"] = static_cast<double>(scene().cloud.size());
}

/// The message of the cloud in PCL's type, as pcl_conversions makes it: fields and bytes are copied.
pcl::PCLPointCloud2 message_of(const Cloud& cloud) {
  pcl::PCLPointCloud2 message;
  message.height = 1;
  message.width = static_cast<std::uint32_t>(cloud.size());
  message.point_step = sizeof(CloudPoint);
  message.row_step = message.width * message.point_step;
  const char* const names[] = {"x", "y", "z", "intensity"};
  for (std::uint32_t i = 0; i < 4; ++i) {
    pcl::PCLPointField field;
    field.name = names[i];
    field.offset = 4 * i;
    field.datatype = pcl::PCLPointField::FLOAT32;
    field.count = 1;
    message.fields.push_back(field);
  }
  message.data.assign(cloud.points_bytes.begin(), cloud.points_bytes.end());
  return message;
}

void bin(Eigen::MatrixXf points, std::vector<float>& ranges) {  // by value, as there
  const float first = -static_cast<float>(M_PI);
  const float step = static_cast<float>(2 * M_PI) / static_cast<float>(ranges.size());
  std::fill(ranges.begin(), ranges.end(), 61.0F);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const float x = points(0, i);
    const float y = points(1, i);
    if (std::isnan(x) || std::isnan(y) || std::isnan(points(2, i))) continue;
    const double range = std::sqrt(static_cast<double>(y * y + x * x));
    const double angle = static_cast<double>(std::atan2(y, x));
    const auto index =
        static_cast<std::size_t>((angle - static_cast<double>(first)) / static_cast<double>(step));
    if (index < ranges.size() && static_cast<double>(ranges[index]) > range)
      ranges[index] = static_cast<float>(range);
  }
}

void ancestor(benchmark::State& state) {
  const auto frames = static_cast<std::size_t>(state.range(0));
  const pcl::PCLPointCloud2 message = message_of(scene().cloud);
  std::vector<float> ranges(scene().grid.beams);
  for (auto _ : state) {
    for (std::size_t f = 0; f < frames; ++f) {
      const pcl::PCLPointCloud2 received = message;
      pcl::PointCloud<pcl::PointXYZ> points;
      pcl::fromPCLPointCloud2(received, points);
      pcl::transformPointCloud(points, points, frame_pose(f).matrix().cast<float>());
      pcl::PCLPointCloud2 moved;
      pcl::toPCLPointCloud2(points, moved);
      Eigen::MatrixXf matrix;
      pcl::getPointCloudAsEigen(moved, matrix);
      bin(matrix, ranges);
      benchmark::DoNotOptimize(ranges.data());
    }
  }
}

BENCHMARK(ancestor)->Name("ancestor's chain of calls")->Arg(1)->Arg(16);
BENCHMARK_CAPTURE(ours, strict slice, Profile::strict, CutMode::slice)->Arg(1)->Arg(16);
BENCHMARK_CAPTURE(ours, strict band, Profile::strict, CutMode::band)->Arg(1);
BENCHMARK_CAPTURE(ours, flatten, Profile::flatten, CutMode::slice)->Arg(1);

}  // namespace
}  // namespace lidard

BENCHMARK_MAIN();
