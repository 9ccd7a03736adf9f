// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands/empty_field.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "core/base/angle.h"
#include "daemon/pipeline/pipeline.h"
#include "drivers/calibration.h"
#include "drivers/driver_base.h"

namespace lidard {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// Stands for any range, m.
constexpr double far_m = 1e5;
constexpr Span period = std::chrono::milliseconds(100);
/// Until an output no longer waits for a source that never comes.
constexpr int field_rounds = 5;

/// Where a sensor is in base_frame, for its driver.
const Pose& place_of(const Model& model) { return *static_cast<const Pose*>(model.row); }

/// Answers every packet with a frame of the empty field.
class FieldDriver final : public DriverBase {
 public:
  explicit FieldDriver(const DriverConfig& config)
      : DriverBase(config), field_(config.model->field), place_(place_of(*config.model)) {
    prepare_scan(config, scan_);
    scan_.scan_time = static_cast<float>(seconds(period));
    choose_beams(config, field_.first_deg * rad_per_deg, field_.step_deg * rad_per_deg, field_.beams, scan_);
    const double most = config.model->range_max;
    farthest_ = config.max_range > 0 ? std::min(config.max_range, most) : most;
  }
  Verdict receive(const Packet& packet, DriverOutput& out) override {
    ++counters_.packets;
    ++counters_.frames;
    if (config_.model->kind == FrameKind::scan)
      send_scan(packet.arrival, out);
    else
      send_cloud(packet.arrival, out);
    is_first_ = false;
    return {true, Reject::none};
  }
  void restart() override {}

 private:
  /// m from the sensor to the ground in a direction of its frame.
  double to_ground(const Eigen::Vector3d& direction) const {
    const double height = place_.translation().z(), climb = (place_.linear() * direction).z();
    return height > 0 && climb < 0 ? height / -climb : infinite;
  }
  void send_scan(Stamp at, DriverOutput& out) {
    scan_.reset(scan_.beams, 1, false);
    scan_.stamp = at;
    for (std::size_t i = 0; i < scan_.beams; ++i) {
      const auto angle = static_cast<double>(scan_.angle(i));
      scan_.set_measured(i, static_cast<float>(to_ground({std::cos(angle), std::sin(angle), 0})));
    }
    if (scan_.beams > 0) out.scan(scan_);
  }
  void send_cloud(Stamp at, DriverOutput& out) {
    cloud_.clear();
    cloud_.frame_id = config_.frame_id;
    cloud_.stamp = at;
    cloud_.end = at + period;
    cloud_.rings = static_cast<std::uint16_t>(field_.elevations_deg.size());
    cloud_.complete = true;
    cloud_.max_range = config_.max_range;
    // A Velodyne turns clockwise.
    for (std::size_t c = 0; c < field_.beams; ++c) {
      const double turned = static_cast<double>(c) * field_.step_deg * rad_per_deg;
      const double angle = -field_.first_deg * rad_per_deg - turned;
      if (config_.in_view(angle)) add_column(at, angle, static_cast<double>(c));
    }
    out.cloud(cloud_);
  }
  void add_column(Stamp at, double angle, double number) {
    const double share = number / static_cast<double>(field_.beams);
    if (config_.model->has(Trait::silent_beams_are_free)) {
      CloudColumn column{};
      column.first_point = static_cast<std::uint32_t>(cloud_.size());
      column.azimuth = static_cast<float>(angle <= 0 ? -angle : two_pi - angle);
      column.stamp = at + span_from_seconds(share * seconds(period));
      cloud_.columns.push_back(column);
    }
    for (std::size_t ring = 0; ring < field_.elevations_deg.size(); ++ring) {
      const double up = field_.elevations_deg[ring] * rad_per_deg;
      const Eigen::Vector3d direction(std::cos(up) * std::cos(angle), std::cos(up) * std::sin(angle),
                                      std::sin(up));
      const double known_from_m = std::min(20.0, farthest_ / 2);
      const double range = std::min(to_ground(direction), is_first_ ? known_from_m : infinite);
      if (!(range >= config_.model->range_min && range <= farthest_)) continue;
      const Eigen::Vector3f p = (range * direction).cast<float>();
      CloudPoint point{p.x(),
                       p.y(),
                       p.z(),
                       0,
                       static_cast<std::uint16_t>(ring),
                       static_cast<float>(share * seconds(period))};
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&point);
      cloud_.points_bytes.insert(cloud_.points_bytes.end(), bytes, bytes + sizeof point);
    }
  }

  const FieldOfView& field_;
  const Pose& place_;
  double farthest_ = 0;  // m
  bool is_first_ = true;
  PlanarScan scan_;
  Cloud cloud_;
};

/// A sensor of which nothing is known.
Model usual_model(FrameKind kind) {
  Model model{"topic", "", "assumed: 270 degrees, 30 m", "", ""};
  model.kind = kind;
  model.frame_period = 0.1;
  model.range_max = kind == FrameKind::scan ? 30 : 100;
  if (kind == FrameKind::scan) {
    model.field = {-135, 0.5, 541};
    return model;
  }
  model.product = "assumed: 16 rings, 100 m";
  model.field = {-180, 0.2, 1800};
  for (int deg = -15; deg <= 15; deg += 2) model.field.elevations_deg.push_back(deg);
  return model;
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

bool does_hold(Limit limit, Limit holds) { return holds == Limit::all || holds == limit; }

void free_from_limits(Limit holds, Model& model, DriverConfig& driver) {
  FieldOfView& field = model.field;
  if (!does_hold(Limit::angles, holds)) {
    field.beams = static_cast<std::size_t>(std::lround(360 / std::abs(field.step_deg)));
    field.first_deg = -180;
    driver.angle_min = driver.angle_max = std::nullopt;
    driver.view_width = two_pi;
  }
  if (!does_hold(Limit::elevations, holds) && model.kind == FrameKind::cloud) {
    // All around.
    field.elevations_deg = {-89.99, -1, -0.3, -0.1, -0.03, -0.01, 0.01, 0.03, 0.1, 0.3, 1, 89.99};
    for (int deg = 3; deg < 90; deg += 3)
      field.elevations_deg.insert(field.elevations_deg.end(), {-1.0 * deg, 1.0 * deg});
    std::sort(field.elevations_deg.begin(), field.elevations_deg.end());
    // So few columns suffice to have what the rings do not see.
    const double turn = field.step_deg * static_cast<double>(field.beams);
    field.step_deg = std::max(field.step_deg, 1.0);
    field.beams = static_cast<std::size_t>(turn / field.step_deg);
  }
  if (!does_hold(Limit::reach, holds)) model.range_max = far_m, driver.max_range = 0;
}

void free_from_limits(Limit holds, Config& config) {
  for (MergedScanConfig& merged : config.merged_scans) {
    for (auto& [name, source] : merged.source_settings) {
      if (!does_hold(Limit::angles, holds)) source.angle_min = -infinite, source.angle_max = infinite;
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

/// Leaves what the field has no part in: odometry, further topics, patience.
void simplify(Config& config) {
  VehicleConfig& vehicle = config.vehicle;
  vehicle.odometry_frame = vehicle.odometry_topic = vehicle.imu_topic = vehicle.speed_topic = "";
  for (MergedScanConfig& merged : config.merged_scans) {
    merged.output.profile = Profile::strict;
    merged.also.clear();
    merged.cloud_destination_topic = merged.status_topic = "";
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

EmptyField::EmptyField(const Config& config, Limit holds) : config_(config), poses_(config, no_tf_) {
  simplify(config_);
  free_from_limits(holds, config_);
  for (SensorConfig& sensor : config_.sensors) set_up(sensor, holds);
  play();
}

void EmptyField::set_up(SensorConfig& sensor, Limit holds) {
  const FrameKind kind = sensor.model != nullptr         ? sensor.model->kind
                         : gives_clouds(sensor, config_) ? FrameKind::cloud
                                                         : FrameKind::scan;
  const bool is_known = sensor.model != nullptr && sensor.model->field.beams > 0;
  if (sensor.model == nullptr) sensor.scan_topic = sensor.points_topic = "assumed/" + sensor.name;
  Model& model = models_.emplace_back(sensor.model != nullptr ? *sensor.model : usual_model(kind));
  if (!is_known) {
    model.field = usual_model(kind).field;
    assumed_.push_back(sensor.name);
  }
  if (const Calibration* own = sensor.driver.calibration.get()) {
    model.field.elevations_deg.clear();
    for (const LaserCalibration& laser : own->lasers)
      model.field.elevations_deg.push_back(laser.vert_correction * deg_per_rad);
    std::sort(model.field.elevations_deg.begin(), model.field.elevations_deg.end());
  }
  free_from_limits(holds, model, sensor.driver);
  Pose& place = places_.emplace_back(Pose::Identity());
  std::string why;
  const bool is_placed = poses_.find(config_.vehicle.base_frame, sensor.frame_id, Stamp{}, place, why);
  // Without a height there is no ground.
  if (!is_placed || !does_hold(kind == FrameKind::scan ? Limit::heights : Limit::elevations, holds))
    place = Pose::Identity();
  if (sensor.pose && kind == FrameKind::cloud && !does_hold(Limit::elevations, holds))
    sensor.pose = level(*sensor.pose);
  model.row = &place;
  model.make = [](const DriverConfig& driver) -> std::unique_ptr<Driver> {
    return std::make_unique<FieldDriver>(driver);
  };
  sensor.model = sensor.driver.model = &model;
  sensor.driver.frame_id = sensor.frame_id;
  sensor.driver.time_offset = Span(0);
  sensor.topic.clear();
  sensor.raw_topic.clear();
  sensor.points_frame.clear();
  sensor.packet_topic = "packets";
  sensor.deskew = false;
  sensor.layout = {};
  sensor.filter = {};
}

void EmptyField::play() {
  Pipeline pipeline(config_, no_tf_, frames_);
  Stamp now{1'000'000'000'000};
  for (int round = 0; round < field_rounds; ++round, now = now + period) {
    for (const SensorConfig& sensor : config_.sensors) {
      Packet packet{};
      packet.arrival = now;
      pipeline.packet_message(sensor.name, packet, now);
    }
  }
  pipeline.advance(now);
}

double EmptyField::blind_range(const SensorConfig& lidar, const Pose& plane_from_lidar) {
  const auto& elevations = lidar.model->field.elevations_deg;
  const double height = plane_from_lidar.translation().z();
  if (elevations.empty() || height == 0) return 0;
  const double towards = (height > 0 ? -elevations.front() : elevations.back()) * rad_per_deg;
  return towards > 0 ? std::abs(height) / std::tan(towards) : 0;
}

}  // namespace lidard
