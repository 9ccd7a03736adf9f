// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "daemon/commands/calibrate.h"
#include "daemon/files/snapshot_view.h"
#include "daemon/files/text_file.h"

namespace lidard {
namespace {

using Points = std::vector<Eigen::Vector2f>;

// Of a cloud the walls are shown: m above the ground. Of a drive so many seconds before and after its middle.
constexpr double lowest_wall = 0.3, highest_wall = 2.5, shown_s = 8;
constexpr std::size_t most_points = 40'000;

void add_point(const CalibratedSensor& sensor, const Eigen::Vector3d& in_base, const PlanarPose& moved,
               Points& points) {
  const bool is_wall = in_base.z() > lowest_wall && in_base.z() < highest_wall;
  if (sensor.is_cloud && !is_wall) return;
  points.push_back((moved * Eigen::Vector2d(in_base.head<2>())).cast<float>());
}

/// What a sensor saw, in base_frame at the stop or in the middle of the drive.
Points points_of(const CalibratedSensor& sensor, const Pose& pose, double time_offset, const Drive* drive,
                 const DriveTrack* track) {
  Points points;
  if (drive == nullptr || sensor.sweeps.empty()) {
    for (const Eigen::Vector3d& p : sensor.scans.points()) add_point(sensor, pose * p, {}, points);
    return points;
  }
  const double middle = drive->odometry.back().time / 2;
  const PlanarPose back = track->at(middle).inverse();
  for (const DriveSweep& sweep : sensor.sweeps) {
    if (std::abs(sweep.time - middle) > shown_s) continue;
    for (const DriveSweep::Return& seen : sweep.returns) {
      const double time = sweep.time + time_offset + static_cast<double>(seen.later);
      add_point(sensor, pose * seen.point.cast<double>(), back * track->at(time), points);
    }
  }
  return points;
}

SnapshotView view_of(const std::vector<CalibratedSensor>& sensors, const Config& config, const Drive* drive,
                     bool after) {
  SnapshotView view;
  view.title = after ? "After" : "Before";
  view.subtitle = after ? "Walls as the poses found place them" : "Walls as the configured poses place them";
  view.base_frame = config.vehicle.base_frame, view.footprint = config.vehicle.footprint;
  std::optional<DriveTrack> track;
  if (drive != nullptr) {
    const DriveSolution& s = drive->solution;
    track.emplace(drive->odometry, after ? s.scale : 1, after ? s.turn_scale : 1);
  }
  for (const CalibratedSensor& sensor : sensors) {
    const Pose& pose = after ? sensor.after : sensor.before;
    const std::size_t number = view.layers.size();
    view.sensors.push_back(
        {sensor.config->name, pose.translation().head<2>(), SnapshotView::Role::input, number});
    SnapshotView::Layer layer;
    layer.number = number, layer.name = sensor.config->name, layer.dot = 1.5;
    const Eigen::Vector3d moved = 1000 * (sensor.after.translation() - sensor.before.translation());
    const Eigen::AngleAxisd turned(sensor.before.linear().transpose() * sensor.after.linear());
    layer.note = sensor.is_changed() ? fmt::format("moved {}, {}, {} mm, {:.2f} deg", std::lround(moved.x()),
                                                   std::lround(moved.y()), std::lround(moved.z()),
                                                   turned.angle() * deg_per_rad)
                                     : "as configured";
    layer.points =
        points_of(sensor, pose, after ? sensor.drive.time_offset : 0, drive, track ? &*track : nullptr);
    const std::size_t stride = layer.points.size() / most_points + 1;
    for (std::size_t i = 0; i * stride < layer.points.size(); ++i) layer.points[i] = layer.points[i * stride];
    layer.points.resize(layer.points.size() / stride);
    view.layers.push_back(std::move(layer));
  }
  return view;
}

}  // namespace

void draw_calibration(const std::string& path, const std::vector<CalibratedSensor>& sensors,
                      const Config& config, const Drive* drive) {
  std::vector<SnapshotView> views{view_of(sensors, config, drive, false),
                                  view_of(sensors, config, drive, true)};
  views[0].framing = views[1].framing = fit_to_points(views[1]);
  constexpr int width = 500, legend_width = 300;
  views[0].framing.width = width, views[1].framing.width = width + legend_width;
  TextFile file(path);
  file.write(draw_snapshot(views, picture_format(path).value()));
  file.close();
}

}  // namespace lidard
