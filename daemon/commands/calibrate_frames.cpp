// SPDX-FileCopyrightText: 2026 the lidard authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/evidence/beam_rays.h"
#include "daemon/commands/calibrate.h"
#include "daemon/offline/no_transforms.h"
#include "daemon/offline/player.h"
#include "daemon/ros/in/bag_topics.h"
#include "daemon/ros/in/tf_poses.h"
#include "daemon/ros/messages/convert.h"

namespace lidard {
namespace {

// More frames add no accuracy: what is left is no noise.
constexpr std::size_t most_scans = 1000, most_clouds = 100, most_sweeps = 600;
// Rings of a multi-plane lidar that are used while the vehicle drives.
constexpr std::size_t most_rings = 16;
constexpr double cloud_step = 0.2 * rad_per_deg;
// s before and after a frame in which the vehicle must stand, and m that its first stop may be away.
constexpr double still_s = 0.3, same_stop_m = 0.01;

/// Sorts the frames that come out of the pipeline, and those of other drivers, into those of the vehicle's
/// stop and sweeps of its drive.
class FrameCollector final : public FrameSink {
 public:
  FrameCollector(const Config& config, const Drive* drive, std::vector<CalibratedSensor>& sensors)
      : drive_(drive),
        vehicle_(Footprint(config.vehicle.footprint).padded(Footprint::margin_m)),
        sensors_(sensors) {}

  void publish(const OutputTopic& topic, const Frame& frame, Stamp /*released*/) override {
    for (CalibratedSensor& sensor : sensors_) {
      if (sensor.config->model == nullptr || frame_topic(*sensor.config).name != topic.name) continue;
      if (const PlanarScan* const scan = frame.scan())
        add(sensor, *scan);
      else if (Cloud* const cloud = frame.cloud(); cloud != nullptr && cloud->complete)
        add(sensor, *cloud);
    }
  }

  void add(CalibratedSensor& sensor, const PlanarScan& scan) {
    if (stands(scan.stamp)) {
      if (sensor.scans.frames() >= most_scans) return;
      if (!sensor.scans.add(scan)) ++sensor.left_out;
    }
    if (DriveSweep* const sweep = next_sweep(sensor, scan.stamp)) {
      sweep->step = std::abs(static_cast<double>(scan.angle_increment));
      for (std::size_t i = 0; i < scan.beams; ++i) {
        if (scan.statuses[i] != BeamStatus::hit) continue;
        const float angle = scan.angle(i), range = scan.ranges[i];
        keep(sensor, {range * std::cos(angle), range * std::sin(angle), 0},
             static_cast<float>(i) * scan.time_increment, 0, *sweep);
      }
    }
  }
  void add(CalibratedSensor& sensor, const Cloud& cloud) {
    sensor.is_cloud = true;
    if (stands(cloud.stamp)) {
      if (sensor.scans.frames() >= most_clouds) return;
      sensor.scans.add(cloud);
    }
    if (DriveSweep* const sweep = next_sweep(sensor, cloud.stamp)) {
      sweep->step = cloud_step;
      std::size_t rings = 1;
      for (std::size_t i = 0; i < cloud.size(); ++i)
        rings = std::max<std::size_t>(rings, cloud.points()[i].ring + 1U);
      const std::size_t stride = (rings + most_rings - 1) / most_rings;
      for (std::size_t c = 0; c < std::max<std::size_t>(1, cloud.columns.size()); ++c) {
        const bool has_columns = !cloud.columns.empty();
        if (has_columns && cloud.columns[c].echo != 0) continue;
        const std::size_t end = has_columns ? cloud.points_end(c) : cloud.size();
        for (std::size_t i = has_columns ? cloud.columns[c].first_point : 0; i < end; ++i) {
          const CloudPoint point = cloud.points()[i];
          if (point.ring % stride == 0)
            keep(sensor, {point.x, point.y, point.z}, point.time, point.ring / stride, *sweep);
        }
      }
    }
  }

 private:
  bool stands(Stamp stamp) {
    if (drive_ == nullptr) return true;
    const double time = drive_->time(stamp);
    if (!drive_->track.stands(time, still_s)) return false;
    if (!stop_) stop_ = time;
    return std::abs(drive_->track.way(time) - drive_->track.way(*stop_)) < same_stop_m;
  }
  /// The sweep that begins then, if one is due while the vehicle drives; without a drive, to see that it
  /// stands.
  DriveSweep* next_sweep(CalibratedSensor& sensor, Stamp stamp) {
    if (!begin_) begin_ = stamp;
    const double time = drive_ == nullptr ? seconds(stamp - *begin_) : drive_->time(stamp);
    const bool is_due = sensor.sweeps.empty() || time >= sensor.sweeps.back().time + keyframe_s;
    if (!is_due || sensor.sweeps.size() >= most_sweeps) return nullptr;
    if (drive_ != nullptr && (!drive_->track.covers(time) || drive_->track.stands(time, still_s)))
      return nullptr;
    sensor.sweeps.push_back({time, 0, {}});
    return &sensor.sweeps.back();
  }
  void keep(const CalibratedSensor& sensor, const Eigen::Vector3f& point, float later, std::size_t ring,
            DriveSweep& sweep) const {
    if (!point.allFinite() || point.norm() < 0.1F) return;
    // The vehicle itself does not move against the sensor.
    const Eigen::Vector3d on_vehicle = sensor.before * point.cast<double>();
    if (!vehicle_.contains(on_vehicle.head<2>()))
      sweep.returns.push_back({point, later, static_cast<std::uint16_t>(ring)});
  }

  const Drive* drive_;
  Footprint vehicle_;
  std::vector<CalibratedSensor>& sensors_;
  std::optional<double> stop_;  // s, when the vehicle first stood
  std::optional<Stamp> begin_;  // of the first frame
};

/// The configuration without what changes the frames of a sensor or is made of them.
Config bare(Config config) {
  config.merged_scans.clear();
  config.merged_clouds.clear();
  config.virtual_scans.clear();
  for (SensorConfig& sensor : config.sensors) {
    sensor.filter = {};
    sensor.layout = {};
    sensor.points_frame.clear();
    sensor.deskew = false;
    sensor.ring_scan.reset();
  }
  return config;
}

/// Adds what other drivers published.
void add_topics(const std::string& path, std::vector<CalibratedSensor>& sensors, FrameCollector& collector) {
  PlanarScan scan;
  Cloud cloud;
  const auto is_of = [](const CalibratedSensor& sensor, const std::string& topic) {
    return !sensor.config->topic.empty() && same_topic(sensor.config->topic, topic);
  };
  const auto bag = open_bags({path});
  bag->choose([&](const std::string& topic) {
    return std::any_of(sensors.begin(), sensors.end(), [&](const auto& one) { return is_of(one, topic); });
  });
  for (BagMessage message; bag->next(message);) {
    for (CalibratedSensor& sensor : sensors) {
      if (!is_of(sensor, message.topic)) continue;
      const Span later = sensor.config->driver.time_offset;
      if (message.scan && from_ros(*message.scan, scan) == nullptr) {
        scan.stamp = scan.stamp + later;
        collector.add(sensor, scan);
      } else if (message.cloud && from_ros(*message.cloud, cloud).error == nullptr) {
        cloud.stamp = cloud.stamp + later;
        collector.add(sensor, cloud);
      }
    }
  }
}

}  // namespace

Drive read_drive(const std::string& path, const VehicleConfig& vehicle) {
  std::vector<OdometryPose> poses;
  Stamp begin;
  for (const auto& [stamp, pose] : open_motion(path, vehicle)->track()) {
    if (poses.empty()) begin = stamp;
    const double time = seconds(stamp - begin);
    if (poses.empty() || time > poses.back().time)
      poses.push_back({time, {pose.translation().x(), pose.translation().y(), yaw_of(pose.linear())}});
  }
  if (poses.size() < 3)
    throw std::runtime_error(path +
                             ": no odometry; expected vehicle.odometry_topic or vehicle.odometry_frame of "
                             "the configuration in a bag, or a .csv with rows of stamp,x,y,yaw");
  return Drive(poses, begin);
}

std::vector<CalibratedSensor> play_calibrated(const CalibrateOptions& options, const Config& config,
                                              const Drive* drive) {
  std::vector<CalibratedSensor> sensors;
  for (const SensorConfig& sensor : config.sensors) {
    if (sensor.pose) sensors.emplace_back(sensor, *sensor.pose);
  }
  FrameCollector collector(config, drive, sensors);
  if (!options.bag.empty()) add_topics(options.bag, sensors, collector);
  MergedCapture capture(options.captures);
  const Config played = bare(config);
  NoTransforms no_motion;
  Pipeline pipeline(played, no_motion, collector);
  ReplayOptions fast;
  fast.rate = 0;
  Player(fast, capture, pipeline).play([] { return false; });
  return sensors;
}

}  // namespace lidard
