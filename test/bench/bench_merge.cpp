// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
// One merge of two scans of 1081 beams into 1440 beams: ours in profiles strict and safety, and the chain of
// calls of ira_laser_tools rebuilt from the libraries it uses, in one program.
#include <benchmark/benchmark.h>
#include <laser_geometry/laser_geometry.h>
#include <pcl/PCLPointCloud2.h>
#include <pcl/common/io.h>
#include <sensor_msgs/LaserScan.h>
#include <sensor_msgs/point_cloud_conversion.h>
#include <tf/tf.h>

#include <algorithm>
#include <cmath>

#include "core/merge/merger.h"
#include "test/support/merge_score.h"

namespace lidard {
namespace {

constexpr std::size_t output_beams = 1440;
constexpr float output_range_max = 24;
const std::vector<char> both = {1, 1};  // scanners

/// The scene that both merge: scanners of 0.25 degrees on opposite corners of a vehicle, boxes around it.
const sim::MergeScene& scene() {
  static const sim::MergeScene made = sim::make_scene(sim::merge_cases()[2], 1);
  return made;
}

/// A vehicle that drives a circle, its poses every 20 ms.
void drive_on(PoseTrack& track, Stamp until) {
  while (track.empty() || track.newest() < until) {
    const Stamp next = track.empty() ? until - std::chrono::milliseconds(200)
                                     : track.newest() + std::chrono::milliseconds(20);
    const double turn = 1e-9 * static_cast<double>(next.ns);
    track.add(next, make_pose({2 * std::sin(turn), 2 - 2 * std::cos(turn), 0}, {0, 0, turn}));
  }
}

void truthful(benchmark::State& state, bool strict, bool safety, bool moving) {
  MergeSettings settings;
  settings.points = false;
  settings.visibility = true;
  settings.how.noise = settings.source.noise = 0.01;
  Merger merger(scene().grid, {}, 2, settings);
  merger.set_footprint(scene().body);
  std::vector<PlanarScan> scans = scene().scans;
  for (PlanarScan& scan : scans) {
    scan.stamp = {1'000'000'000};
    scan.time_increment = 0.02F / static_cast<float>(scan.beams);
  }
  PoseTrack track;
  PlanarScan first, second;
  std::vector<MergedScan> outputs;
  if (strict) outputs.push_back({Profile::strict, &first});
  if (safety) outputs.push_back({Profile::safety, &second});
  const auto merge = [&] {
    for (std::size_t s = 0; s < 2; ++s) {
      scans[s].stamp = scans[s].stamp + std::chrono::milliseconds(25);
      merger.add(s, scans[s], scene().scanners[s].pose());
    }
    if (moving) drive_on(track, scans[1].stamp + std::chrono::milliseconds(40));
    merger.merge({scans[1].stamp + std::chrono::milliseconds(20), moving ? &track : nullptr}, both, outputs,
                 nullptr);
  };
  scans[1].stamp = scans[1].stamp + std::chrono::milliseconds(1);
  merge();
  for (auto _ : state) merge();
  benchmark::DoNotOptimize(strict ? first.ranges.data() : second.ranges.data());
}

void flatten(benchmark::State& state) {
  Merger merger(scene().grid, {}, 2);
  std::vector<PlanarScan> scans = scene().scans;
  PlanarScan out;
  const std::vector<MergedScan> outputs = {{Profile::flatten, &out}};
  for (auto _ : state) {
    for (std::size_t s = 0; s < 2; ++s) {
      scans[s].stamp = scans[s].stamp + std::chrono::milliseconds(25);
      merger.add(s, scans[s], scene().scanners[s].pose());
    }
    merger.merge({scans[1].stamp}, both, outputs, nullptr);
  }
  benchmark::DoNotOptimize(out.ranges.data());
}

sensor_msgs::LaserScan message_of(const PlanarScan& scan, const std::string& frame) {
  sensor_msgs::LaserScan message;
  message.header.frame_id = frame;
  message.header.stamp = ros::Time(1000);
  message.angle_min = scan.angle_min;
  message.angle_max = scan.angle_max;
  message.angle_increment = scan.angle_increment;
  message.range_max = scan.range_max;
  message.ranges = scan.ranges;
  message.intensities = scan.intensities;
  return message;
}

void place(tf::Transformer& tree, const std::string& frame, const sim::FlatScanner& scanner) {
  const tf::Transform pose(tf::createQuaternionFromYaw(scanner.yaw),
                           tf::Vector3(scanner.at.x(), scanner.at.y(), 0));
  for (const double at : {999.0, 1001.0}) {
    tree.setTransform(tf::StampedTransform(pose, ros::Time(at), "base", frame));
  }
}

/// A cloud moved to the output frame, as tf::TransformListener::transformPointCloud moves it.
void move_points(const tf::Transformer& tree, sensor_msgs::PointCloud& cloud) {
  tf::StampedTransform pose;
  tree.lookupTransform("base", cloud.header.frame_id, cloud.header.stamp, pose);
  for (auto& point : cloud.points) {
    const tf::Vector3 moved = pose * tf::Vector3(static_cast<double>(point.x), static_cast<double>(point.y),
                                                 static_cast<double>(point.z));
    point.x = static_cast<float>(moved.x());
    point.y = static_cast<float>(moved.y());
    point.z = static_cast<float>(moved.z());
  }
}

/// The fields and bytes of a message in PCL's own type; pcl_conversions copies them too.
void to_pcl(const sensor_msgs::PointCloud2& from, pcl::PCLPointCloud2& to) {
  to.height = from.height;
  to.width = from.width;
  to.point_step = from.point_step;
  to.row_step = from.row_step;
  to.fields.clear();
  for (const auto& field : from.fields) {
    pcl::PCLPointField one;
    one.name = field.name;
    one.offset = field.offset;
    one.datatype = field.datatype;
    one.count = field.count;
    to.fields.push_back(one);
  }
  to.data = from.data;
}

void bin(const Eigen::MatrixXf& points, std::vector<float>& ranges) {
  const float first = -static_cast<float>(M_PI);
  const float step = static_cast<float>(2 * M_PI) / static_cast<float>(output_beams);
  ranges.assign(output_beams, output_range_max + 1);
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const float x = points(0, i);
    const float y = points(1, i);
    if (std::isnan(x) || std::isnan(y) || std::isnan(points(2, i))) continue;
    const double range = std::sqrt(static_cast<double>(y * y + x * x));
    const double angle = static_cast<double>(std::atan2(y, x));
    if (angle < static_cast<double>(first) || angle > -static_cast<double>(first)) continue;
    const auto index =
        static_cast<std::size_t>((angle - static_cast<double>(first)) / static_cast<double>(step));
    if (index < ranges.size() && static_cast<double>(ranges[index]) > range)
      ranges[index] = static_cast<float>(range);
  }
}

void ancestor(benchmark::State& state) {
  tf::Transformer tree(true, ros::Duration(10));
  const std::string frames[] = {"a", "b"};
  std::vector<sensor_msgs::LaserScan> scans;
  for (std::size_t s = 0; s < 2; ++s) {
    place(tree, frames[s], scene().scanners[s]);
    scans.push_back(message_of(scene().scans[s], frames[s]));
  }
  laser_geometry::LaserProjection projection;
  std::vector<float> ranges;
  for (auto _ : state) {
    pcl::PCLPointCloud2 clouds[2];
    for (std::size_t s = 0; s < 2; ++s) {
      sensor_msgs::PointCloud in_sensor;
      projection.transformLaserScanToPointCloud(frames[s], scans[s], in_sensor, tree,
                                                laser_geometry::channel_option::Distance);
      move_points(tree, in_sensor);
      sensor_msgs::PointCloud2 message;
      sensor_msgs::convertPointCloudToPointCloud2(in_sensor, message);
      to_pcl(message, clouds[s]);
    }
    pcl::PCLPointCloud2 merged = clouds[0];
    pcl::concatenate(merged, clouds[1], merged);
    Eigen::MatrixXf points;
    pcl::getPointCloudAsEigen(merged, points);
    bin(points, ranges);
    benchmark::DoNotOptimize(ranges.data());
  }
}

BENCHMARK(ancestor)->Name("ancestor's chain of calls");
BENCHMARK_CAPTURE(truthful, strict_and_safety, true, true, false);
BENCHMARK_CAPTURE(truthful, strict_and_safety_deskewed, true, true, true);
BENCHMARK_CAPTURE(truthful, strict, true, false, false);
BENCHMARK(flatten);

}  // namespace
}  // namespace lidard

BENCHMARK_MAIN();
