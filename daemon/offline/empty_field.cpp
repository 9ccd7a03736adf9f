// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/offline/empty_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/angle.h"
#include "core/frames/ring_scan.h"
#include "daemon/pipeline/pipeline.h"
#include "drivers/calibration.h"
#include "drivers/driver_base.h"
#include "drivers/registry/registry.h"

namespace lidard {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// Stands for any range, m.
constexpr double far_m = 1e5;
constexpr Span period = std::chrono::milliseconds(100);
/// Until an output no longer waits for a source that never comes.
constexpr int field_rounds = 5;

bool does_hold(Limit limit, Limit holds) { return holds == Limit::all || holds == limit; }

/// Sends what a sensor measures in the empty field.
class FieldSensor {
 public:
  FieldSensor(const SensorConfig& config, const FieldOfView& view, const Pose& pose, bool has_reach)
      : config_(config), view_(view), pose_(pose) {
    const double limit = config.driver.max_range, most = config.model->range_max;
    farthest_ = !has_reach ? far_m : limit > 0 ? std::min(limit, most) : most;
    scan_.frame_id = cloud_.frame_id = config.frame_id;
    scan_.range_min = static_cast<float>(config.model->range_min);
    scan_.range_max = static_cast<float>(has_reach ? most : far_m);
    scan_.scan_time = static_cast<float>(seconds(period));
    choose_beams(config.driver, view.first_deg * rad_per_deg, view.step_deg * rad_per_deg, view.beams, scan_);
    cloud_.rings = static_cast<std::uint16_t>(view.elevations_deg.size());
    cloud_.complete = true;
    cloud_.max_range = has_reach ? limit : 0;
    if (config.ring_scan) ring_scan_.emplace(*config.ring_scan);
  }

  /// Also keeps what it sends.
  void send(Stamp now, Pipeline& pipeline, FrameKeeper& frames) {
    if (config_.model->kind == FrameKind::scan) {
      measure_scan(now - period);
      frames.publish(frame_topic(config_), scan_, now);
      return pipeline.scan_message(config_.name, scan_, now);
    }
    measure_cloud(now - period);
    frames.publish(frame_topic(config_), cloud_, now);
    pipeline.cloud_message(config_.name, cloud_, now);
    if (ring_scan_ && ring_scan_->convert(cloud_, scan_)) pipeline.scan_message(config_.name, scan_, now);
    is_first_ = false;
  }

 private:
  /// m from the sensor to the ground in a direction of its frame.
  double to_ground(const Eigen::Vector3d& direction) const {
    const double height = pose_.translation().z(), climb = (pose_.linear() * direction).z();
    return height > 0 && climb < 0 ? height / -climb : infinite;
  }
  void measure_scan(Stamp begin) {
    scan_.reset(scan_.beams, 1, false);
    scan_.stamp = begin;
    for (std::size_t i = 0; i < scan_.beams; ++i) {
      const auto angle = static_cast<double>(scan_.angle(i));
      scan_.set_measured(i, static_cast<float>(to_ground({std::cos(angle), std::sin(angle), 0})));
    }
  }
  void measure_cloud(Stamp begin) {
    cloud_.points_bytes.clear();
    cloud_.columns.clear();
    cloud_.stamp = begin;
    cloud_.end = begin + period;
    // A Velodyne turns clockwise.
    for (std::size_t c = 0; c < view_.beams; ++c) {
      const double angle = -(view_.first_deg + static_cast<double>(c) * view_.step_deg) * rad_per_deg;
      const double share = static_cast<double>(c) / static_cast<double>(view_.beams);
      if (config_.driver.in_view(angle)) add_column(angle, seconds(period) * share);
    }
  }
  void add_column(double angle, double time_s) {
    CloudColumn column{};
    column.first_point = static_cast<std::uint32_t>(cloud_.size());
    column.azimuth = static_cast<float>(angle <= 0 ? -angle : two_pi - angle);
    column.stamp = cloud_.stamp + span_from_seconds(time_s);
    cloud_.columns.push_back(column);
    const double known_from_m = is_first_ ? std::min(20.0, farthest_ / 2) : infinite;
    for (std::size_t ring = 0; ring < view_.elevations_deg.size(); ++ring) {
      const double up = view_.elevations_deg[ring] * rad_per_deg;
      const Eigen::Vector3d direction(std::cos(up) * std::cos(angle), std::cos(up) * std::sin(angle),
                                      std::sin(up));
      const double range = std::min(to_ground(direction), known_from_m);
      if (!(range >= config_.model->range_min && range <= farthest_)) continue;
      const Eigen::Vector3f p = (range * direction).cast<float>();
      cloud_.points_bytes.resize(cloud_.points_bytes.size() + sizeof(CloudPoint));
      cloud_.points()[cloud_.size() - 1] = {
          p.x(), p.y(), p.z(), 0, static_cast<std::uint16_t>(ring), static_cast<float>(time_s)};
    }
  }

  const SensorConfig& config_;
  const FieldOfView& view_;
  Pose pose_;
  double farthest_ = 0;  // m
  bool is_first_ = true;
  PlanarScan scan_;  // or the ring of a lidar that is a scan
  Cloud cloud_;
  std::optional<RingScan> ring_scan_;
};

/// The field of view of a sensor by its calibration, else by its model.
FieldOfView view_of(const SensorConfig& sensor) {
  FieldOfView view = sensor.model->field;
  if (view.beams == 0) view = usual_model(sensor.model->kind).field;
  const Calibration* const own = own_calibration(sensor.driver);
  if (own == nullptr) return view;
  view.elevations_deg.clear();
  for (const LaserCalibration& laser : own->lasers)
    view.elevations_deg.push_back(laser.vert_correction * deg_per_rad);
  std::sort(view.elevations_deg.begin(), view.elevations_deg.end());
  return view;
}

/// True if a source with `topic:` gives clouds, as far as its uses show.
bool gives_clouds(const SensorConfig& sensor, const Config& config) {
  return std::any_of(config.virtual_scans.begin(), config.virtual_scans.end(), [&](const auto& group) {
    const auto lidars = config.lidars_of(group);
    return std::find(lidars.begin(), lidars.end(), sensor.name) != lidars.end();
  });
}

/// At the one height of lidars and virtual scans, and level.
Pose level(const Pose& pose) {
  constexpr double height_m = 2;
  return make_pose({pose.translation().x(), pose.translation().y(), height_m},
                   {0, 0, std::atan2(pose.linear()(1, 0), pose.linear()(0, 0))});
}

void free_from_limits(Limit holds, FieldOfView& view, DriverConfig& driver) {
  if (!does_hold(Limit::angles, holds)) {
    view.beams = static_cast<std::size_t>(std::lround(360 / std::abs(view.step_deg)));
    view.first_deg = -180;
    driver.angle_min = driver.angle_max = std::nullopt;
    driver.view_width = two_pi;
  }
  if (does_hold(Limit::elevations, holds) || view.elevations_deg.empty()) return;
  view.elevations_deg.clear();
  for (double deg = 0.01; deg < 90; deg += std::min(2 * deg, 3.0))
    view.elevations_deg.insert(view.elevations_deg.end(), {-deg, deg});
  std::sort(view.elevations_deg.begin(), view.elevations_deg.end());
  // So few columns suffice to have what the rings do not see.
  const double turn = view.step_deg * static_cast<double>(view.beams);
  view.step_deg = std::max(view.step_deg, 1.0);
  view.beams = static_cast<std::size_t>(turn / view.step_deg);
}

void free_from_limits(Limit holds, Config& config) {
  for (MergedScanConfig& merged : config.merged_scans) {
    for (auto& [name, source] : merged.source_settings) {
      if (!does_hold(Limit::angles, holds)) source.angle_min = source.angle_max = std::nullopt;
      if (does_hold(Limit::reach, holds)) continue;
      source.range_min = 0;
      source.range_max = source.no_return_free_range = infinite;
    }
    if (!does_hold(Limit::heights, holds)) merged.output.min_height = merged.output.max_height = std::nullopt;
  }
  for (VirtualScanConfig& group : config.virtual_scans) {
    if (!does_hold(Limit::reach, holds)) group.no_return_free_range = far_m;
    if (does_hold(Limit::elevations, holds)) continue;
    for (auto& [frame, pose] : group.poses) pose = level(pose);
  }
}

/// Leaves out odometry and patience, in which the field has no part.
void simplify(Config& config) {
  VehicleConfig& vehicle = config.vehicle;
  vehicle.odometry_frame = vehicle.odometry_topic = vehicle.imu_topic = vehicle.speed_topic = "";
  for (MergedScanConfig& merged : config.merged_scans) {
    merged.output.profile = Profile::strict;
    merged.also.clear();
    merged.schedule.lost_after = 2 * period;
    merged.schedule.deadline.reset();
  }
  for (MergedCloudConfig& merged : config.merged_clouds) {
    merged.schedule.lost_after = 2 * period;
    merged.schedule.deadline.reset();
  }
  for (VirtualScanConfig& group : config.virtual_scans) group.output.profile = Profile::strict;
}

}  // namespace

const Model& usual_model(FrameKind kind) {
  return *find_model(kind == FrameKind::scan ? "sick_tim7xx" : "velodyne_vlp16");
}

EmptyField::EmptyField(const Config& config, Limit holds)
    : config_(config), poses_(config.vehicle.base_frame, fixed_poses(config), no_tf_) {
  simplify(config_);
  free_from_limits(holds, config_);
  for (SensorConfig& sensor : config_.sensors) {
    if (sensor.model == nullptr || sensor.model->field.beams == 0) assumed_.push_back(sensor.name);
    if (sensor.model == nullptr) {
      sensor.model = &usual_model(gives_clouds(sensor, config_) ? FrameKind::cloud : FrameKind::scan);
      sensor.scan_topic = sensor.points_topic = "assumed/" + sensor.name;
    }
    views_[sensor.name] = view_of(sensor);
    free_from_limits(holds, views_[sensor.name], sensor.driver);
  }
  play(holds);
}

Pose EmptyField::pose_of(const SensorConfig& sensor, Limit holds) const {
  const bool is_scanner = sensor.model->kind == FrameKind::scan;
  Pose pose;
  std::string why;
  const bool has_pose = poses_.find(config_.vehicle.base_frame, sensor.frame_id, Stamp{}, pose, why);
  // Without a height there is no ground.
  const bool has_height = does_hold(is_scanner ? Limit::heights : Limit::elevations, holds);
  return has_pose && has_height ? pose : Pose::Identity();
}

/// Every sensor is played as a topic of another driver, which brings frames instead of packets.
void EmptyField::play(Limit holds) {
  Config played = config_;
  std::vector<FieldSensor> sensors;
  for (std::size_t i = 0; i < config_.sensors.size(); ++i) {
    const SensorConfig& sensor = config_.sensors[i];
    sensors.emplace_back(sensor, views_[sensor.name], pose_of(sensor, holds), does_hold(Limit::reach, holds));
    SensorConfig& topic = played.sensors[i];
    topic.model = topic.driver.model = nullptr;
    topic.topic = topic.name;
    topic.driver.time_offset = Span(0);
    if (sensor.pose && !sensor.model->field.elevations_deg.empty() && !does_hold(Limit::elevations, holds))
      topic.pose = level(*sensor.pose);
  }
  Pipeline pipeline(played, no_tf_, frames_);
  Stamp now{1'000'000'000'000};
  for (int round = 0; round < field_rounds; ++round, now = now + period) {
    for (FieldSensor& sensor : sensors) sensor.send(now, pipeline, frames_);
  }
  pipeline.advance(now);
}

double EmptyField::blind_range(const SensorConfig& lidar, const Pose& plane_from_lidar) const {
  const auto& elevations = views_.at(lidar.name).elevations_deg;
  const double height = plane_from_lidar.translation().z();
  if (elevations.empty() || height == 0) return 0;
  const double towards = (height > 0 ? -elevations.front() : elevations.back()) * rad_per_deg;
  return towards > 0 ? std::abs(height) / std::tan(towards) : 0;
}

}  // namespace lidard
